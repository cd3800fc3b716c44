// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Common parts of the readers of all kinds of models. Private to Inference.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "IO/Weights/SafetensorsFile.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// Version of the format of model files, in their metadata.
constexpr const char* ModelFormatVersion = "1";

/// Shapes of tensors by name.
using TensorShapes = std::map<std::string, std::vector<std::int64_t>>;

/// Describes the first three differences between the tensors that a network needs and those of a file, and the number
/// of the others; "" when there is none.
std::string DifferencesOf(const TensorShapes& expected, const TensorShapes& found);

/// Checks that the metadata name this architecture, in format version 1 or @p newest.
/// @param kind end of the message: "a flow matching model, as vtkFlowMatchingTrainer writes it"
/// @throws ModelMismatch
void RequireArchitecture(const SafetensorsFile& file, const std::string& architecture, const std::string& kind,
  const std::string& newest = ModelFormatVersion);

/// Maximum number of weights and other numbers of a model, 2^28: 1 GiB in float32.
constexpr std::int64_t MaximumModelSize = std::int64_t(1) << 28;

/// Checks the number of all elements of a file against MaximumModelSize.
/// @throws ModelMismatch
void RequireModelSize(const SafetensorsFile& file);

/// Shapes of the tensors of a file.
TensorShapes ShapesIn(const SafetensorsFile& file);

/// Rows of a tensor of a file; 1 where there is none or it has no rows, for what DifferencesOf() then names.
std::int64_t RowsIn(const SafetensorsFile& file, const std::string& tensor);

/// Checks names, shapes and number of the tensors of a file, and that they are finite.
/// @param kind in the message, behind "the tensors are not those of" @param integers a tensor of integers, if there is one
/// @throws ModelMismatch, FormatError
void RequireTensors(
  const SafetensorsFile& file, const TensorShapes& expected, const std::string& kind, const std::string& integers = "");

/// Reads points, [V, 3], from a tensor of that shape.
/// @throws ModelMismatch when it holds integers.
PointMatrix ReadPoints(const SafetensorsFile& file, const std::string& tensor);

/// Reads triangles, [F, 3], from a tensor of that shape. A number that is no vertex id in any mesh becomes one that is out of
/// range.
/// @throws ModelMismatch when it holds floating-point numbers.
TriangleMatrix ReadTriangles(const SafetensorsFile& file, const std::string& tensor);

/// Reader of typed values from a JSON object in the metadata. All functions throw ModelMismatch naming the key, its
/// value and the expected one.
class DescriptionReader
{
public:
  /// Parses the JSON object under @p key of the metadata.
  DescriptionReader(const SafetensorsFile& file, std::string key);

  /// Value of a key that holds a number.
  double Number(const char* key) const;
  /// Value of a key that holds a number, or @p otherwise without the key: for keys that earlier versions do not have.
  double NumberOr(const char* key, double otherwise) const;
  /// Value of a key that holds an integer.
  std::int64_t WholeNumber(const char* key) const;
  /// Value of a key that holds a string.
  std::string String(const char* key) const;
  /// Value of a key that holds a string, or @p otherwise without the key.
  std::string StringOr(const char* key, const std::string& otherwise) const;
  /// Value of a key that holds an array of numbers.
  std::vector<double> Numbers(const char* key) const;
  /// Throws ModelMismatch about the value of @p key.
  [[noreturn]] void Fail(const std::string& key, const std::string& expected) const;

private:
  std::string File;
  std::string Key;
  nlohmann::json Json;
};

} // namespace surfsynth
