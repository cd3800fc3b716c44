// SPDX-License-Identifier: BSD-3-Clause
#include "pqResultsBehavior.h"

#include <pqApplicationCore.h>
#include <pqDataRepresentation.h>
#include <pqOutputPort.h>
#include <pqPipelineSource.h>
#include <pqRepresentation.h>
#include <pqServerManagerModel.h>
#include <pqView.h>
#include <vtkPVDataInformation.h>
#include <vtkPVXMLElement.h>
#include <vtkSMPVRepresentationProxy.h>
#include <vtkSMProperty.h>
#include <vtkSMPropertyHelper.h>
#include <vtkSMProxy.h>

#include <QAbstractItemModel>
#include <QHeaderView>
#include <QPointer>
#include <QStringList>
#include <QTableView>
#include <QTimer>

#include <cstring>
#include <string>

namespace
{
/// True for a filter of the plugin, by its place in the menu.
bool isOfPlugin(pqPipelineSource* source)
{
  vtkPVXMLElement* hints = source->getProxy()->GetHints();
  vtkPVXMLElement* menu = hints ? hints->FindNestedElementByName("ShowInMenu") : nullptr;
  const char* category = menu ? menu->GetAttribute("category") : nullptr;
  return category && std::strncmp(category, "Surface Synthesis", 17) == 0;
}

/// Columns of Topology Report, those first that are read first.
QStringList reportColumns() { return { "Property", "Value", "First", "Remark", "Block", "Component" }; }
} // namespace

pqResultsBehavior::pqResultsBehavior(QObject* parentObject)
  : Superclass(parentObject)
{}

void pqResultsBehavior::onStartup()
{
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  QObject::connect(model, &pqServerManagerModel::viewAdded, this, &pqResultsBehavior::watchTable);
  QObject::connect(model, &pqServerManagerModel::dataUpdated, this, &pqResultsBehavior::colorLateResults);
  QObject::connect(model, &pqServerManagerModel::representationAdded, this, &pqResultsBehavior::showDirectColors);
  for (pqView* view : model->findItems<pqView*>())
  {
    this->watchTable(view);
  }
}

void pqResultsBehavior::onShutdown()
{
  QObject::disconnect(pqApplicationCore::instance()->getServerManagerModel(), nullptr, this, nullptr);
}

void pqResultsBehavior::watchTable(pqView* view)
{
  auto* table = view->widget() ? view->widget()->findChild<QTableView*>() : nullptr;
  if (!table || !table->model())
  {
    return;
  }
  QHeaderView* header = table->horizontalHeader();
  const auto arrange = [header]() { pqResultsBehavior::leadWithValues(header); };
  QObject::connect(table->model(), &QAbstractItemModel::headerDataChanged, header, arrange);
  QObject::connect(table->model(), &QAbstractItemModel::modelReset, header, arrange);
}

void pqResultsBehavior::leadWithValues(QHeaderView* header)
{
  QStringList columns;
  for (int k = 0; k < header->model()->columnCount(); ++k)
  {
    columns << header->model()->headerData(k, Qt::Horizontal).toString();
  }
  QStringList order = reportColumns();
  bool isReport = true;
  for (const QString& name : order)
  {
    isReport = isReport && columns.contains(name);
  }
  if (!isReport)
  {
    order = header->sectionsMoved() ? columns : QStringList(); // another table, in its own order
  }
  for (int place = 0; place < order.size(); ++place)
  {
    header->moveSection(header->visualIndex(columns.indexOf(order[place])), place);
  }
  QStringList shown;
  for (int place = 0; place < columns.size(); ++place)
  {
    shown << columns[header->logicalIndex(place)];
  }
  header->setProperty("columns", shown.join(' '));
}

void pqResultsBehavior::colorLateResults(pqPipelineSource* source)
{
  if (!isOfPlugin(source))
  {
    return;
  }
  for (int k = 0; k < source->getNumberOfOutputPorts(); ++k)
  {
    pqOutputPort* port = source->getOutputPort(k);
    if (port->getDataInformation()->GetNumberOfPoints() == 0)
    {
      this->EmptyPorts.insert(port);
    }
    else if (this->EmptyPorts.remove(port))
    {
      // after the representations have been updated
      QTimer::singleShot(0, port, [port]() { pqResultsBehavior::colorByArray(port); });
    }
  }
}

void pqResultsBehavior::showDirectColors(pqRepresentation* shown)
{
  auto* representation = qobject_cast<pqDataRepresentation*>(shown);
  pqOutputPort* port = representation ? representation->getOutputPortFromInput() : nullptr;
  if (!port || pqApplicationCore::instance()->isLoadingState() || !isOfPlugin(port->getSource()))
  {
    return;
  }
  vtkPVXMLElement* colors = port->getSource()->getProxy()->GetHints()->FindNestedElementByName("DirectColors");
  int number = -1;
  if (colors && colors->GetScalarAttribute("port", &number) && number == port->getPortNumber())
  {
    vtkSMPropertyHelper(representation->getProxy(), "MapScalars", true).Set(0);
    representation->getProxy()->UpdateVTKObjects();
  }
}

void pqResultsBehavior::colorByArray(pqOutputPort* port)
{
  for (pqView* view : port->getViews())
  {
    pqDataRepresentation* shown = port->getRepresentation(view);
    auto* representation = vtkSMPVRepresentationProxy::SafeDownCast(shown ? shown->getProxy() : nullptr);
    vtkSMProperty* colors = representation ? representation->GetProperty("ColorArrayName") : nullptr;
    if (!colors || vtkSMPVRepresentationProxy::GetUsingScalarColoring(representation))
    {
      continue;
    }
    colors->ResetToDomainDefaults();
    const vtkSMPropertyHelper array(colors);
    const std::string name = array.GetInputArrayNameToProcess();
    if (!name.empty())
    {
      vtkSMPVRepresentationProxy::SetScalarColoring(representation, name.c_str(), array.GetInputArrayAssociation());
      vtkSMPVRepresentationProxy::RescaleTransferFunctionToDataRange(representation);
      vtkSMPVRepresentationProxy::SetScalarBarVisibility(representation, view->getProxy(), true);
    }
    view->render();
  }
}
