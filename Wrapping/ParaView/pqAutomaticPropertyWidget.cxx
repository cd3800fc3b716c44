// SPDX-License-Identifier: BSD-3-Clause
#include "pqAutomaticPropertyWidget.h"

#include <vtkPVXMLElement.h>
#include <vtkSMIntVectorProperty.h>

#include <QCheckBox>
#include <QDoubleValidator>
#include <QHBoxLayout>
#include <QIntValidator>
#include <QLineEdit>
#include <QLocale>

pqAutomaticPropertyWidget::pqAutomaticPropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parentWidget)
  : Superclass(proxy, parentWidget)
  , Field(new QLineEdit(this))
  , Box(new QCheckBox(this))
{
  vtkPVXMLElement* hints = property->GetHints();
  vtkPVXMLElement* hint = hints ? hints->FindNestedElementByName("Automatic") : nullptr;
  const char* text = hint ? hint->GetAttribute("text") : nullptr;
  if (hint)
  {
    hint->GetScalarAttribute("value", &this->AutomaticValue);
  }
  this->Field->setObjectName("Field");
  this->Box->setObjectName("Automatic");
  this->Box->setText(text ? text : tr("automatic"));
  if (vtkSMIntVectorProperty::SafeDownCast(property))
  {
    this->Field->setValidator(new QIntValidator(this->Field));
  }
  else
  {
    auto* validator = new QDoubleValidator(this->Field);
    validator->setLocale(QLocale::c());
    this->Field->setValidator(validator);
  }

  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(this->Field, 1);
  row->addWidget(this->Box);

  QObject::connect(this->Box, &QCheckBox::toggled, this, [this]() {
    this->showState();
    Q_EMIT this->valueChanged();
  });
  QObject::connect(this->Field, &QLineEdit::textChanged, this, &pqAutomaticPropertyWidget::valueChanged);

  this->Box->setChecked(true);
  this->addPropertyLink(this, "value", SIGNAL(valueChanged()), property);
  this->setChangeAvailableAsChangeFinished(true);
}

double pqAutomaticPropertyWidget::value() const
{
  bool isNumber = false;
  const double number = QLocale::c().toDouble(this->Field->text(), &isNumber);
  return isNumber && !this->Box->isChecked() ? number : this->AutomaticValue;
}

void pqAutomaticPropertyWidget::setValue(double value)
{
  if (value > this->AutomaticValue)
  {
    if (value != this->value())
    {
      this->Field->setText(QLocale::c().toString(value, 'g', QLocale::FloatingPointShortest));
    }
    this->Box->setChecked(false);
  }
  else if (this->value() > this->AutomaticValue)
  {
    this->Box->setChecked(true);
  }
  this->showState();
}

void pqAutomaticPropertyWidget::showState()
{
  this->Field->setEnabled(!this->Box->isChecked());
  this->Field->setPlaceholderText(this->Box->text());
  if (this->Box->isChecked())
  {
    this->Field->clear();
  }
}
