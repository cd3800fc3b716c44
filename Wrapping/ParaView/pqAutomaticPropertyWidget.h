// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqAutomaticPropertyWidget
 * @brief   Edits a number of which one value stands for an automatic choice: a field, and a box that says so
 *
 * For IntVectorProperty and DoubleVectorProperty with one element and panel_widget="surface_synthesis_automatic". The
 * hint <Automatic value="0" text="automatic"/> names that value, and the label of the box; numbers below it mean the
 * same. The property, states and scripts keep the number.
 */

#ifndef pqAutomaticPropertyWidget_h
#define pqAutomaticPropertyWidget_h

#include <pqPropertyWidget.h>

class QCheckBox;
class QLineEdit;

class pqAutomaticPropertyWidget : public pqPropertyWidget
{
  Q_OBJECT
  Q_PROPERTY(double value READ value WRITE setValue NOTIFY valueChanged)
  typedef pqPropertyWidget Superclass;

public:
  explicit pqAutomaticPropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);
  ~pqAutomaticPropertyWidget() override = default;

  /// Number in the field; the automatic one while the box is checked or the field is empty.
  double value() const;
  void setValue(double value);

Q_SIGNALS:
  void valueChanged();

private:
  Q_DISABLE_COPY(pqAutomaticPropertyWidget)

  void showState();

  double AutomaticValue = 0.0;
  QLineEdit* Field;
  QCheckBox* Box;
};

#endif
