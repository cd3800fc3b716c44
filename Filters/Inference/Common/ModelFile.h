// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What the readers of all kinds of models share. Private to Learning.
#pragma once

#include "IO/Weights/SafetensorsFile.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

using TensorShapes = std::map<std::string, std::vector<std::int64_t>>;

/// "[2, 3]"
std::string FormatShape(const std::vector<std::int64_t>& shape);

/// The first three differences between the tensors that a network needs and those that are there, and how many more; ""
/// when there is none.
std::string DifferencesOf(const TensorShapes& expected, const TensorShapes& found);

/// @throws ModelMismatch unless the metadata say that it is this kind of model, in version 1. @p kind ends the message:
/// "a flow matching model, as vtkFlowMatchingTrainer writes it".
void RequireArchitecture(const SafetensorsFile& file, const std::string& architecture, const std::string& kind);

/// Reads typed values of a JSON object that the metadata hold under a key. All throw ModelMismatch naming the value,
/// what it is and what was expected.
class DescriptionReader
{
public:
  DescriptionReader(const SafetensorsFile& file, std::string key);

  double Number(const char* key) const;
  /// For keys that files of earlier versions do not have.
  double NumberOr(const char* key, double otherwise) const;
  std::int64_t WholeNumber(const char* key) const;
  std::string String(const char* key) const;
  std::vector<double> Numbers(const char* key) const;
  [[noreturn]] void Fail(const std::string& key, const std::string& expected) const;

private:
  std::string File;
  std::string Key;
  nlohmann::json Json;
};

} // namespace surfsynth
