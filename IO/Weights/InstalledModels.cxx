// SPDX-License-Identifier: BSD-3-Clause
#include "InstalledModels.h"

#include "SafetensorsFile.h"

#include "Core/Common/Errors.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <system_error>

namespace surfsynth
{

namespace
{
constexpr const char* Extension = ".safetensors";

/// A library lies up to this many folders below its installation.
constexpr int Depth = 8;

/// Folder of the library or program that holds this function.
std::filesystem::path FolderOfLibrary()
{
  Dl_info info;
  if (dladdr(reinterpret_cast<const void*>(&InstalledModelsFolder), &info) == 0 || !info.dli_fname)
  {
    return {};
  }
  std::error_code error;
  return std::filesystem::canonical(info.dli_fname, error).parent_path();
}
} // namespace

std::string InstalledModelsFolder()
{
  if (const char* given = std::getenv("SURFACE_SYNTHESIS_MODELS"))
  {
    return given;
  }
  std::filesystem::path folder = FolderOfLibrary();
  for (int k = 0; k < Depth && folder.has_relative_path(); ++k, folder = folder.parent_path())
  {
    std::error_code error;
    const std::filesystem::path models = folder / "share" / "SurfaceSynthesis" / "Models";
    if (std::filesystem::is_directory(models, error))
    {
      return models.string();
    }
  }
  return {};
}

std::vector<std::string> InstalledModels(const ModelPredicate& isWanted)
{
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(InstalledModelsFolder(), error))
  {
    try
    {
      if (entry.path().extension() == Extension && entry.is_regular_file() &&
        isWanted(SafetensorsFile(entry.path().string()).Metadata()))
      {
        names.push_back(entry.path().stem().string());
      }
    }
    catch (const std::exception&) // no model file
    {
      continue;
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string ModelPath(const std::string& name)
{
  const std::filesystem::path path(name);
  std::error_code error;
  if (name.empty() || path.has_parent_path() || path.has_extension() || std::filesystem::exists(path, error))
  {
    return name;
  }
  const std::filesystem::path installed = std::filesystem::path(InstalledModelsFolder()) / (name + Extension);
  return std::filesystem::is_regular_file(installed, error) ? installed.string() : name;
}

std::string ExistingModelPath(const std::string& name)
{
  std::string found = ModelPath(name);
  const std::filesystem::path path(found);
  std::error_code error;
  if (path.has_parent_path() || path.has_extension() || std::filesystem::exists(path, error))
  {
    return found;
  }
  const std::string folder = InstalledModelsFolder();
  throw InvalidInput("There is no installed model \"" + name + "\" (" +
    (folder.empty() ? "no folder of installed models is found" : "in " + folder) +
    ") and no file of this name; the path of a model file, or the name of an installed model, is needed.");
}

} // namespace surfsynth
