// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSeedPropertyWidget
 * @brief   Edits an integer seed: a spin box, and a button that fills in another seed
 *
 * For IntVectorProperty with one element and panel_widget="surface_synthesis_seed". The button only changes the value
 * that is shown; Apply uses it, as with any other property, and state and trace hold the number.
 */

#ifndef pqSeedPropertyWidget_h
#define pqSeedPropertyWidget_h

#include <pqPropertyWidget.h>

class pqSeedPropertyWidget : public pqPropertyWidget
{
  Q_OBJECT
  typedef pqPropertyWidget Superclass;

public:
  explicit pqSeedPropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);
  ~pqSeedPropertyWidget() override = default;

private:
  Q_DISABLE_COPY(pqSeedPropertyWidget)
};

#endif
