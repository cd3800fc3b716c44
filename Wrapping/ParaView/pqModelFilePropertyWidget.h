// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqModelFilePropertyWidget
 * @brief   Chooses a model or an example: a list of the installed ones with their pictures, or a file of one's own
 *
 * For StringVectorProperty with one element and panel_widget="surface_synthesis_modelfile", on a proxy with the information
 * properties InstalledModels (names) and InstalledModelsFolder, or InstalledExamples and InstalledExamplesFolder. The property holds the name of an installed model or
 * the path of a file. The file dialog opens in the folder of the installed models. Pictures are the files NAME.png in
 * that folder, where this program can read them.
 */

#ifndef pqModelFilePropertyWidget_h
#define pqModelFilePropertyWidget_h

#include <pqPropertyWidget.h>

#include <QString>

class QComboBox;
class QLineEdit;
class QToolButton;

class pqModelFilePropertyWidget : public pqPropertyWidget
{
  Q_OBJECT
  Q_PROPERTY(QString model READ model WRITE setModel NOTIFY modelChanged)
  typedef pqPropertyWidget Superclass;

public:
  explicit pqModelFilePropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);
  ~pqModelFilePropertyWidget() override = default;

  /// Name of an installed model, or path of a file.
  QString model() const;
  void setModel(const QString& model);

Q_SIGNALS:
  void modelChanged();

private:
  Q_DISABLE_COPY(pqModelFilePropertyWidget)

  void fillList();
  void showFile();
  void chooseFile();
  bool ownFile() const;

  QString Folder;
  QComboBox* Models;
  QLineEdit* File;
  QToolButton* Browse;
};

#endif
