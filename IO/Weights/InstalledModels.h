// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Trained models that come with the library, known by their names.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// True for a model that is wanted, by the metadata of its file.
using ModelPredicate = std::function<bool(const std::map<std::string, std::string>& metadata)>;

/// Returns the folder of the model files: the environment variable SURFACE_SYNTHESIS_MODELS where it is set, else
/// share/SurfaceSynthesis/Models in the build or installation that the running library lies in. Empty without one.
std::string InstalledModelsFolder();

/// Returns the names of the models in InstalledModelsFolder() for which @p isWanted is true, in alphabetical order:
/// "knobs" for the file knobs.safetensors. Files that cannot be read are left out.
std::vector<std::string> InstalledModels(const ModelPredicate& isWanted);

/// Returns the path of a model file that a user has named: @p name itself, or the file of the installed model of this
/// name where @p name has no folder and no extension and no such file exists.
std::string ModelPath(const std::string& name);

/// The same for a name that must be found.
/// @throws InvalidInput when @p name has no folder and no extension, and is neither a file nor an installed model. The text
/// names the folder of the installed models.
std::string ExistingModelPath(const std::string& name);

} // namespace surfsynth
