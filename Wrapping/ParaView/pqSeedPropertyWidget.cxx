// SPDX-License-Identifier: BSD-3-Clause
#include "pqSeedPropertyWidget.h"

#include <QHBoxLayout>
#include <QPushButton>
#include <QRandomGenerator>
#include <QSpinBox>

#include <limits>

pqSeedPropertyWidget::pqSeedPropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parentWidget)
  : Superclass(proxy, parentWidget)
{
  auto* seed = new QSpinBox(this);
  seed->setObjectName("Seed");
  seed->setRange(std::numeric_limits<int>::min(), std::numeric_limits<int>::max());
  seed->setKeyboardTracking(false);

  auto* newSeed = new QPushButton(tr("New seed"), this);
  newSeed->setObjectName("NewSeed");
  newSeed->setToolTip(tr("Fill in another seed"));

  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(seed, 1);
  layout->addWidget(newSeed);

  // Up to six digits, so that a seed can be read, noted and typed.
  QObject::connect(newSeed, &QPushButton::clicked, seed, [seed]() {
    const int other = QRandomGenerator::global()->bounded(999999);
    seed->setValue(other < seed->value() ? other : other + 1);
  });

  this->addPropertyLink(seed, "value", SIGNAL(valueChanged(int)), property);
  this->setChangeAvailableAsChangeFinished(true);
}
