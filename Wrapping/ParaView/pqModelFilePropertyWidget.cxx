// SPDX-License-Identifier: BSD-3-Clause
#include "pqModelFilePropertyWidget.h"

#include <pqApplicationCore.h>
#include <pqFileDialog.h>
#include <pqServerManagerModel.h>
#include <vtkSMPropertyHelper.h>
#include <vtkSMProxy.h>

#include <QComboBox>
#include <QDir>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QIcon>
#include <QLineEdit>
#include <QSignalBlocker>
#include <QToolButton>
#include <QVBoxLayout>

#include <string>

namespace
{
constexpr int PictureSize = 48;
}

pqModelFilePropertyWidget::pqModelFilePropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parentWidget)
  : Superclass(proxy, parentWidget)
  , Models(new QComboBox(this))
  , File(new QLineEdit(this))
  , Browse(new QToolButton(this))
{
  this->Models->setObjectName("Models");
  this->Models->setIconSize(QSize(PictureSize, PictureSize));
  this->File->setObjectName("File");
  this->File->setPlaceholderText(tr("Path of a file"));
  this->Browse->setObjectName("Browse");
  this->Browse->setText("...");
  this->Browse->setToolTip(tr("Choose a file"));
  this->fillList();

  auto* row = new QHBoxLayout;
  row->addWidget(this->File, 1);
  row->addWidget(this->Browse);
  auto* rows = new QVBoxLayout(this);
  rows->setContentsMargins(0, 0, 0, 0);
  rows->addWidget(this->Models);
  rows->addLayout(row);
  this->showFile();

  QObject::connect(this->Models, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this]() {
    this->showFile();
    Q_EMIT this->modelChanged();
  });
  QObject::connect(this->File, &QLineEdit::textChanged, this, &pqModelFilePropertyWidget::modelChanged);
  QObject::connect(this->Browse, &QToolButton::clicked, this, [this]() { this->chooseFile(); });

  this->addPropertyLink(this, "model", SIGNAL(modelChanged()), property);
  this->setChangeAvailableAsChangeFinished(true);
}

void pqModelFilePropertyWidget::fillList()
{
  vtkSMProxy* source = this->proxy();
  source->UpdatePropertyInformation();
  const std::string installed = source->GetProperty("InstalledExamples") ? "InstalledExamples" : "InstalledModels";
  const vtkSMPropertyHelper folder(source, (installed + "Folder").c_str(), true);
  const vtkSMPropertyHelper names(source, installed.c_str(), true);
  this->Folder = folder.GetNumberOfElements() > 0 ? QString::fromUtf8(folder.GetAsString(0)) : QString();
  for (unsigned int k = 0; k < names.GetNumberOfElements(); ++k)
  {
    const QString name = QString::fromUtf8(names.GetAsString(k));
    const QString picture = QDir(this->Folder).filePath(name + ".png");
    this->Models->addItem(QFileInfo::exists(picture) ? QIcon(picture) : QIcon(), name, name);
  }
  this->Models->addItem(tr("File ..."));
}

bool pqModelFilePropertyWidget::ownFile() const { return this->Models->currentIndex() == this->Models->count() - 1; }

QString pqModelFilePropertyWidget::model() const
{
  return this->ownFile() ? this->File->text() : this->Models->currentData().toString();
}

void pqModelFilePropertyWidget::setModel(const QString& model)
{
  if (model == this->model())
  {
    return;
  }
  const QSignalBlocker models(this->Models);
  const QSignalBlocker file(this->File);
  const int installed = this->Models->findData(model);
  this->Models->setCurrentIndex(installed >= 0 ? installed : this->Models->count() - 1);
  this->File->setText(installed >= 0 ? QString() : model);
  this->showFile();
  Q_EMIT this->modelChanged();
}

void pqModelFilePropertyWidget::showFile()
{
  this->File->setVisible(this->ownFile());
  this->Browse->setVisible(this->ownFile());
}

void pqModelFilePropertyWidget::chooseFile()
{
  pqServer* server = pqApplicationCore::instance()->getServerManagerModel()->findServer(this->proxy()->GetSession());
  pqFileDialog dialog(server, this, tr("Open File:"), this->Folder, tr("Safetensors (*.safetensors);;All files (*)"));
  dialog.setObjectName("ModelFileDialog");
  dialog.setFileMode(pqFileDialog::ExistingFile);
  if (dialog.exec() == QDialog::Accepted && !dialog.getSelectedFiles().isEmpty())
  {
    this->File->setText(dialog.getSelectedFiles().first());
  }
}
