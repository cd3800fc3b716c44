// SPDX-License-Identifier: BSD-3-Clause
#include "InstalledModelList.h"

#include "IO/Weights/InstalledModels.h"

namespace surfsynth
{

vtkStringArray* InstalledModelList::Names(const std::string& architecture, const std::string& text)
{
  const auto isWanted = [&](const std::map<std::string, std::string>& metadata) {
    const auto found = metadata.find("architecture");
    const auto details = metadata.find(architecture);
    return found != metadata.end() && found->second == architecture &&
      (text.empty() || (details != metadata.end() && details->second.find(text) != std::string::npos));
  };
  this->NameArray->Initialize();
  for (const std::string& name : InstalledModels(isWanted))
  {
    this->NameArray->InsertNextValue(name);
  }
  return this->NameArray;
}

const char* InstalledModelList::Folder()
{
  this->FolderName = InstalledModelsFolder();
  return this->FolderName.c_str();
}

} // namespace surfsynth
