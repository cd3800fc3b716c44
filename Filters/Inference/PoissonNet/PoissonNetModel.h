// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A trained PoissonNet [Maesumi2025], and its file. No torch.
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

/// Normalisation of a mesh before the network, the same as in training.
enum class InputNormalization
{
  None, ///< the caller's coordinates
  /// minus the area-weighted centroid, over sqrt(area). Published networks add 1e-8 to it, which single precision does not
  /// see at areas near 1, and which would give small surfaces, such as a cell of 1e-6 m, another area.
  SurfaceArea,
  UnitSphere ///< minus the area-weighted centroid, over the largest distance from it
};

/// A trained network: options, weights, normalisation of the input, names of the output.
struct PoissonNetModel
{
  PoissonNetOptions Options;                  ///< architecture
  std::map<std::string, ModelTensor> Tensors; ///< by published names; exactly those of ExpectedTensors(Options)
  InputNormalization Normalization = InputNormalization::None; ///< normalisation of the mesh
  /// Names of the classes of a classifier in the order of its channels; empty when the file names none.
  std::vector<std::string> Classes;
  std::map<std::string, std::string> Metadata; ///< metadata of the file, unchanged

  /// True for a network whose output are log-probabilities of classes.
  bool IsClassifier() const { return this->Options.Activation == LastActivation::LogSoftmax; }
};

/// Reads a model file. Beside the keys of OptionsFromMetadata() it knows `architecture` ("poissonnet" where it is
/// there), `format_version` ("1"), `input_normalisation` ("none", "surface_area", "unit_sphere"; none where absent)
/// and `classes` (a JSON array of names, or names separated by commas).
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a weight is
/// not finite; ModelMismatch when it does not describe a PoissonNet, or names or shapes of its tensors are not those
/// of the network it describes, naming the first three.
PoissonNetModel ReadPoissonNet(const std::string& path);

/// Reads a model from an open file: the tensors whose names begin with @p prefix. Same errors.
PoissonNetModel ReadPoissonNet(const SafetensorsFile& file, const std::string& prefix = "");

/// Reads one network of a file that holds several. The metadata under the key @p part are a JSON object of the strings
/// of a file with that network alone; the tensors are named "<part>.<published name>". Same errors.
PoissonNetModel ReadPartNetwork(const SafetensorsFile& file, const std::string& part);

/// Adds tensors and metadata of one network to those of a file to be written: the inverse of ReadPartNetwork().
/// @throws InvalidInput as CheckModel().
void AddPartNetwork(const std::string& part, const PoissonNetModel& model, std::map<std::string, TensorData>& tensors,
  std::map<std::string, std::string>& metadata);

/// Checks that the tensors of a model are those of its options. A model from a file passes.
/// @throws InvalidInput naming the tensors that are missing, of another shape or superfluous.
void CheckModel(const PoissonNetModel& model);

/// Writes a model file in float32; metadata that ReadPoissonNet() does not know is kept.
/// @throws InvalidInput when the model is not complete or the file cannot be written.
void WritePoissonNet(const std::string& path, const PoissonNetModel& model);

} // namespace surfsynth
