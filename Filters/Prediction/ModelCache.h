// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The model file of a filter, read again only when it has changed.
#pragma once

#include "Learning/Models/PoissonNetModel.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace surfsynth
{

/// Holds the model of the last file that was asked for.
class ModelCache
{
public:
  /// The model of the file: the one that was read last when path, size and modification time of the file are the same.
  /// @throws InvalidInput when there is no such file; what ReadPoissonNet() throws. Then no model is held.
  std::shared_ptr<const PoissonNetModel> Get(const std::string& path);

  /// Files read since this object was made.
  std::int64_t NumberOfLoads() const { return this->Loads; }

private:
  std::shared_ptr<const PoissonNetModel> Model;
  std::string Path;
  std::filesystem::file_time_type Time;
  std::uintmax_t Size = 0;
  std::int64_t Loads = 0;
};

} // namespace surfsynth
