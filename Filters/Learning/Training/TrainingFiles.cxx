// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TrainingFiles.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Learning/Training/TrainingCheckpoint.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

namespace surfsynth
{

namespace
{
namespace fs = std::filesystem;

/// True when both names are of one file, which need not exist.
bool AreOneFile(const fs::path& a, const fs::path& b)
{
  std::error_code absent;
  return fs::absolute(a).lexically_normal() == fs::absolute(b).lexically_normal() || fs::equivalent(a, b, absent);
}

void RequirePlace(const std::string& what, const fs::path& path)
{
  std::error_code unknown;
  const bool occupied = fs::exists(path, unknown) && !fs::is_regular_file(path, unknown);
  if (!fs::is_directory(fs::absolute(path).parent_path(), unknown) || occupied)
  {
    throw InvalidInput("TrainingFiles: the file of the " + what + ", \"" + path.string() +
      "\", cannot be written: its folder does not exist, or it is a folder or a device; expected the name of a file in "
      "a folder.");
  }
}
} // namespace

void CheckFiles(const TrainingFiles& files)
{
  if (files.CheckpointInterval < 1)
  {
    throw InvalidInput("TrainingFiles: the checkpoint interval is " + std::to_string(files.CheckpointInterval) +
      "; expected at least 1.");
  }
  if (!(files.TimeBudget >= 0.0) || !std::isfinite(files.TimeBudget))
  {
    throw InvalidInput("TrainingFiles: the time budget is " + FormatNumber(files.TimeBudget) +
      " minutes; expected a number of at least 0, 0 for no limit.");
  }
  const std::array<std::pair<const char*, fs::path>, 4> places = { std::pair("model", fs::path(files.Model)),
    std::pair("checkpoint", fs::path(files.Checkpoint)), std::pair("loss table", fs::path(files.LossTable)),
    std::pair("sample", fs::path(files.Sample)) };
  for (std::size_t k = 0; k < places.size(); ++k)
  {
    const auto& [what, path] = places[k];
    if (path.empty())
    {
      continue;
    }
    RequirePlace(what, path);
    for (std::size_t other = 0; other < k; ++other)
    {
      if (!places[other].second.empty() && AreOneFile(path, places[other].second))
      {
        throw InvalidInput("TrainingFiles: \"" + path.string() + "\" is the file of both the " + places[other].first +
          " and the " + what + "; expected a file for each.");
      }
    }
    for (const std::string& input : files.Inputs)
    {
      if (!input.empty() && AreOneFile(path, input))
      {
        throw InvalidInput("TrainingFiles: the file of the " + std::string(what) + ", \"" + path.string() +
          "\", is one that the training is made from; expected another name.");
      }
    }
  }
}

bool HasCheckpoint(const TrainingFiles& files)
{
  return files.Resume && !files.Checkpoint.empty() && fs::exists(files.Checkpoint);
}

std::int64_t CheckpointIterations(const TrainingFiles& files)
{
  return HasCheckpoint(files) ? ReadCheckpointHeader(files.Checkpoint).Iterations : 0;
}

} // namespace surfsynth
