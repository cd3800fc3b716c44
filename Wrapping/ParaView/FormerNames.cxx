// SPDX-License-Identifier: BSD-3-Clause
#include "FormerNames.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkPVXMLElement.h>
#include <vtkSMProperty.h>
#include <vtkSMPropertyIterator.h>
#include <vtkSMProxy.h>
#include <vtkSMProxyIterator.h>
#include <vtkSMProxyManager.h>
#include <vtkSMSessionProxyManager.h>
#include <vtkSMVectorProperty.h>
#include <vtkSmartPointer.h>

namespace surfsynth
{

namespace
{
/// Name of the property that has taken the place of @p property; null when it is no former one.
const char* SuccessorOf(vtkSMProperty* property)
{
  vtkPVXMLElement* hints = property ? property->GetHints() : nullptr;
  vtkPVXMLElement* former = hints ? hints->FindNestedElementByName("FormerName") : nullptr;
  return former ? former->GetAttribute("of") : nullptr;
}

void HandOver(vtkSMProxy* proxy)
{
  bool changed = false;
  const auto properties = vtkSmartPointer<vtkSMPropertyIterator>::Take(proxy->NewPropertyIterator());
  for (properties->Begin(); !properties->IsAtEnd(); properties->Next())
  {
    const char* name = SuccessorOf(properties->GetProperty());
    auto* former = vtkSMVectorProperty::SafeDownCast(properties->GetProperty());
    auto* successor = vtkSMVectorProperty::SafeDownCast(name ? proxy->GetProperty(name) : nullptr);
    if (former && successor && former->GetNumberOfElements() == 1 && successor->GetNumberOfElements() == 1)
    {
      successor->Copy(former);
      successor->Modified();
      former->SetNumberOfElements(0);
      changed = true;
    }
  }
  if (changed)
  {
    proxy->UpdateVTKObjects();
  }
}

void AfterLoading(vtkObject*, unsigned long, void*, void*)
{
  vtkNew<vtkSMProxyIterator> proxies;
  proxies->SetSessionProxyManager(vtkSMProxyManager::GetProxyManager()->GetActiveSessionProxyManager());
  proxies->SetModeToOneGroup();
  for (proxies->Begin("sources"); !proxies->IsAtEnd(); proxies->Next())
  {
    HandOver(proxies->GetProxy());
  }
}
} // namespace

void KeepFormerNames()
{
  vtkNew<vtkCallbackCommand> observer;
  observer->SetCallback(AfterLoading);
  vtkSMProxyManager::GetProxyManager()->AddObserver(vtkCommand::LoadStateEvent, observer);
}

} // namespace surfsynth
