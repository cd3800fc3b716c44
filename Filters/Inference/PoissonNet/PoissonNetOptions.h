// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Architecture of a PoissonNet: its options, and the tensors of a model file. No torch.
#pragma once

#include "Inference/PoissonNet/PoissonOperators.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// Map from the last features to the output.
enum class PoissonNetHead
{
  Linear,        ///< an affine map to OutputChannels
  GradientDomain ///< "njf": new gradients of the positions, integrated to positions [Aigerman2022]
};

/// Domain of the output of a linear head.
enum class PoissonNetDomain
{
  Vertices, ///< one row for each vertex
  Faces,    ///< one row for each face: mean of the three corners, before the last activation
  Global    ///< one row: mass-weighted mean over the vertices, before the last activation
};

/// Activation of the output.
enum class LastActivation
{
  Identity,  ///< none
  LogSoftmax ///< over the channels: the model is a classifier
};

/// Options of the architecture of [Maesumi2025], also that of [Kuai2026], section 4 and appendix B.1.
struct PoissonNetOptions
{
  std::int64_t InputChannels = 3;  ///< channels of the vertex signal; 3 = positions, for a gradient-domain head
  std::int64_t OutputChannels = 3; ///< channels of a linear head; a gradient-domain head always has 3
  std::int64_t Width = 128;        ///< hidden channels
  std::int64_t Blocks = 5;         ///< number of blocks
  std::int64_t ComplexLayers = 3;  ///< number of layers of each complex MLP; the last one is linear
  std::int64_t ExtraFeatures = 0;  ///< channels of the condition that enters every block; 0 = none
  bool Modulate = true;            ///< the face features turn and scale the gradients before the complex MLP of a block
  bool ModulateHead = false;       ///< the face features also turn and scale the gradients in a gradient-domain head
  bool InnerProducts = false;      ///< blocks feed on dot products of gradients, averaged to the vertices
  bool Normalize = false;          ///< per-channel norm over the vertices of the inputs of the vertex MLP
  bool MassWeightedNorm = false;   ///< the norm weighs vertices by their mass
  double Dropout = 0.0;            ///< [0, 1), in the vertex MLPs; acts in training only
  PoissonShift Shift = PoissonShift::Identity; ///< of the Poisson equation: that of the operators that it runs on
  PoissonNetHead Head = PoissonNetHead::GradientDomain; ///< head
  PoissonNetDomain Domain = PoissonNetDomain::Vertices; ///< domain of a linear head
  LastActivation Activation = LastActivation::Identity; ///< activation of a linear head

  /// Number of channels of the network's output.
  std::int64_t ResultChannels() const
  {
    return this->Head == PoissonNetHead::GradientDomain ? 3 : this->OutputChannels;
  }
};

/// Checks the options.
/// @throws InvalidInput naming the first option that is out of its range: 1 to 100,000 channels, 1 to 1,000 blocks, 1
/// to 100 layers, a gradient-domain head with 3 input channels and no activation at the vertices.
void CheckOptions(const PoissonNetOptions& options);

/// Shapes of all tensors of the state dictionary, by their published names.
std::map<std::string, std::vector<std::int64_t>> ExpectedTensors(const PoissonNetOptions& options);

/// Reads the options from the metadata of a model file (keys config, head, C_in, C_out, C_width, n_blocks,
/// extra_features, outputs_at, last_activation). Unknown keys of config are ignored: they are about training.
/// @param file for messages.
/// @throws ModelMismatch naming the key, its value and the expected one.
PoissonNetOptions OptionsFromMetadata(const std::string& file, const std::map<std::string, std::string>& metadata);

/// Writes the options as metadata: the inverse of OptionsFromMetadata().
std::map<std::string, std::string> MetadataFromOptions(const PoissonNetOptions& options);

} // namespace surfsynth
