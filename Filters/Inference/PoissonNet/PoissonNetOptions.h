// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a PoissonNet is made of: its options, and the tensors that a model file must hold for them. No torch.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace surfsynth
{

/// How the last features become the output.
enum class PoissonNetHead
{
  Linear,        ///< an affine map to OutputChannels
  GradientDomain ///< "njf": new gradients of the positions, integrated to positions (Aigerman et al. 2022)
};

/// Where the output of a linear head lives.
enum class PoissonNetDomain
{
  Vertices,
  Faces, ///< mean of the three corners, before the last activation
  Global ///< mass-weighted mean over the vertices, before the last activation
};

enum class LastActivation
{
  Identity,
  LogSoftmax ///< over the channels: the model is a classifier
};

/// The architecture of section 4 and appendix B.1 of "Matérn Noise for Triangulation-Agnostic Flow Matching on Meshes",
/// which is that of "PoissonNet: A Local-Global Approach for Learning on Surfaces" (Maesumi et al. 2025).
struct PoissonNetOptions
{
  std::int64_t InputChannels = 3;  ///< of the vertex signal; 3 = positions, which a gradient-domain head needs
  std::int64_t OutputChannels = 3; ///< of a linear head; a gradient-domain head always has 3
  std::int64_t Width = 128;        ///< hidden channels
  std::int64_t Blocks = 5;
  std::int64_t ComplexLayers = 3; ///< of each complex MLP; the last one is linear
  std::int64_t ExtraFeatures = 0; ///< channels of the condition that enters every block; 0 = none
  bool Modulate = true;           ///< the face features turn and scale the gradients before the complex MLP of a block
  bool ModulateHead = false;      ///< the same in the gradient-domain head
  bool InnerProducts = false;     ///< blocks feed on dot products of gradients, averaged to the vertices
  bool Normalise = false;         ///< per-channel norm over the vertices of what enters the vertex MLP
  bool MassWeightedNorm = false;  ///< that norm weighs vertices by their mass
  double Dropout = 0.0;           ///< [0, 1), in the vertex MLPs; acts in training only
  PoissonNetHead Head = PoissonNetHead::GradientDomain;
  PoissonNetDomain Domain = PoissonNetDomain::Vertices;
  LastActivation Activation = LastActivation::Identity;

  /// Channels of the network's output.
  std::int64_t ResultChannels() const
  {
    return this->Head == PoissonNetHead::GradientDomain ? 3 : this->OutputChannels;
  }
};

/// @throws InvalidInput naming the first option that is out of its range: 1 to 100,000 channels, 1 to 1,000 blocks, 1
/// to 100 layers, a gradient-domain head with 3 input channels and no activation at the vertices.
void CheckOptions(const PoissonNetOptions& options);

/// Shapes of all tensors of the state dictionary, by their published names.
std::map<std::string, std::vector<std::int64_t>> ExpectedTensors(const PoissonNetOptions& options);

/// The options that the metadata of a model file describe (keys config, head, C_in, C_out, C_width, n_blocks,
/// extra_features, outputs_at, last_activation). Keys of config that are not known here are ignored: they are about
/// training.
/// @param file for messages.
/// @throws ModelMismatch naming the key, what was found and what was expected.
PoissonNetOptions OptionsFromMetadata(const std::string& file, const std::map<std::string, std::string>& metadata);

/// The inverse of OptionsFromMetadata().
std::map<std::string, std::string> MetadataFromOptions(const PoissonNetOptions& options);

} // namespace surfsynth
