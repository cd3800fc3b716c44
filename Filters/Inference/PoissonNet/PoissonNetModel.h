// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A PoissonNet as a model file holds it. No torch.
#pragma once

#include "Inference/Common/ModelTensor.h"
#include "Inference/PoissonNet/PoissonNetOptions.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

class SafetensorsFile;
struct TensorData;

/// What a mesh goes through before the network sees it, as it did in training.
enum class InputNormalisation
{
  None,
  SurfaceArea, ///< minus the area-weighted centroid, over sqrt(area) + 1e-8
  UnitSphere   ///< minus the area-weighted centroid, over the largest distance from it
};

/// A trained network: options, weights, and what its users must know.
struct PoissonNetModel
{
  PoissonNetOptions Options;
  std::map<std::string, ModelTensor> Tensors; ///< by published names; exactly those of ExpectedTensors(Options)
  InputNormalisation Normalisation = InputNormalisation::None;
  /// Names of the classes of a classifier in the order of its channels; empty when the file names none.
  std::vector<std::string> Classes;
  std::map<std::string, std::string> Metadata; ///< of the file, as it was

  bool IsClassifier() const { return this->Options.Activation == LastActivation::LogSoftmax; }
};

/// Reads a model file. Beside the keys of OptionsFromMetadata() it knows `architecture` ("poissonnet" where it is
/// there), `format_version` ("1"), `input_normalisation` ("none", "surface_area", "unit_sphere"; none where absent)
/// and `classes` (a JSON array of names, or names separated by commas).
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a weight is
/// not finite; ModelMismatch when it does not describe a PoissonNet, or names or shapes of its tensors are not those
/// of the network it describes, naming the first three.
PoissonNetModel ReadPoissonNet(const std::string& path);

/// The same from an open file, of the tensors whose names begin with @p prefix.
PoissonNetModel ReadPoissonNet(const SafetensorsFile& file, const std::string& prefix = "");

/// One network of a file that holds several: the metadata under the key @p part are a JSON object of the strings that
/// a file with that network alone would have, and its tensors are named "<part>.<published name>". Same errors.
PoissonNetModel ReadPartNetwork(const SafetensorsFile& file, const std::string& part);

/// The inverse of ReadPartNetwork(): adds tensors and the metadata of one network to those of a file to be written.
/// @throws InvalidInput as CheckModel().
void AddPartNetwork(const std::string& part, const PoissonNetModel& model, std::map<std::string, TensorData>& tensors,
  std::map<std::string, std::string>& metadata);

/// @throws InvalidInput naming what is missing, of another shape or too much, when the tensors of a model that was
/// made by hand are not those of its options. What was read from a file is complete.
void CheckModel(const PoissonNetModel& model);

/// Writes a model file in float32; metadata that ReadPoissonNet() does not know is kept.
/// @throws InvalidInput when the model is not complete or the file cannot be written.
void WritePoissonNet(const std::string& path, const PoissonNetModel& model);

} // namespace surfsynth
