// SPDX-License-Identifier: BSD-3-Clause
#include "IO/Datasets/DatasetFiles.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"

#include <set>

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

void RequireNumbers(const SafetensorsFile& file, const std::string& prefix, std::size_t count)
{
  std::set<std::string> known;
  for (std::size_t k = 0; k < count; ++k)
  {
    known.insert(std::to_string(k));
  }
  const std::string start = prefix + ".";
  for (auto tensor = file.Tensors().lower_bound(start);
       tensor != file.Tensors().end() && tensor->first.compare(0, start.size(), start) == 0; ++tensor)
  {
    const std::string number = tensor->first.substr(start.size(), tensor->first.find('.', start.size()) - start.size());
    if (known.count(number) == 0)
    {
      throw ModelMismatch(file.Name() + ": there is a tensor \"" + tensor->first + "\", and \"" + start +
        std::to_string(count) + "\" is missing; expected numbers 0, 1, ... without a gap.");
    }
  }
}

} // namespace surfsynth
