// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Datasets/DatasetFiles.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"

namespace surfsynth
{

const std::string& RequireMetadata(
  const SafetensorsFile& file, const std::string& key, const std::string& expected, const std::string& kind)
{
  const auto found = file.Metadata().find(key);
  if (found == file.Metadata().end() || (!expected.empty() && found->second != expected))
  {
    throw ModelMismatch(file.Name() + ": the metadata \"" + key + "\" is " +
      (found == file.Metadata().end() ? "missing" : "\"" + found->second + "\"") + "; expected " +
      (expected.empty() ? "a name" : "\"" + expected + "\"") + ", " + kind + ".");
  }
  return found->second;
}

} // namespace surfsynth
