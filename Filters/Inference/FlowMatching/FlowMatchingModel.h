// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A trained flow matching model, and its file. No torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Noise/MaternField.h"
#include "Inference/PoissonNet/MeshNormalisation.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace surfsynth
{

/// The distribution of the signal at flow time 0, on the mesh in the network's coordinates (area 1).
struct FlowNoise
{
  NoiseModel Model = NoiseModel::Matern;
  double Screening = 100.0;      ///< tau > 0 of Matern and Spectral; the paper's 100
  std::int64_t Eigenpairs = 256; ///< of Spectral
  double Scale = 1.0;            ///< every value is multiplied by it
  double Smoothing = 0.0;        ///< s >= 0 of Matern, see FlowNoiseField; the paper's 0
};

/// The options of the MaternField that samples @p noise before it is scaled and smoothed.
MaternFieldOptions FieldOptions(const FlowNoise& noise);

/// What is remembered of the surfaces of the training, so that another kind of surface is noticed: the second moments
/// xx, xy, xz, yy, yz, zz of the surface in the network's coordinates, which do not depend on its triangulation.
struct ShapeMoments
{
  Eigen::Matrix<double, 1, 6> Mean = Eigen::Matrix<double, 1, 6>::Zero();
  double Spread = 0.0; ///< the largest MomentDistance() of a surface of the training from Mean
};

/// Second moments of @p mesh about its area-weighted centroid, over its area: [xx, xy, xz, yy, yz, zz].
Eigen::Matrix<double, 1, 6> SecondMoments(const TriangleMesh& mesh);

/// Frobenius norm of the difference of two second moments, over the trace of the first; 0 for the same shape in the same
/// orientation, about 1 for one that is turned by a right angle.
double MomentDistance(const Eigen::Matrix<double, 1, 6>& expected, const Eigen::Matrix<double, 1, 6>& found);

/// A velocity field on signals, F(f_t, t; condition), trained to carry noise to data: section 4 of "Matérn Noise for
/// Triangulation-Agnostic Flow Matching on Meshes".
///
/// The network's coordinates are those of the source surface moved to its centroid and scaled to area 1. Positions are
/// signals in those coordinates with mean 0; other signals are (value - SignalMean) / SignalScale. The condition of each
/// vertex is [t, position (3), what the encoder predicts there].
struct FlowMatchingModel
{
  /// Numbers of the condition before those of the encoder: time and position.
  static constexpr std::int64_t PlainConditions = 4;

  PoissonNetModel Velocity;
  /// Predicts a positional encoding from positions where a model serves many surfaces (section 5.1.2).
  std::optional<PoissonNetModel> Encoder;
  FlowNoise Noise;
  std::string SignalName = "Position"; ///< "Position" for deformations
  Eigen::RowVectorXd SignalMean;       ///< [C]; 0 for positions
  Eigen::RowVectorXd SignalScale;      ///< [C], > 0; 1 for positions
  ShapeMoments Shape;
  std::int64_t Iterations = 0;                 ///< of its training
  std::map<std::string, std::string> Metadata; ///< of the file, as it was

  bool GeneratesPositions() const { return this->SignalName == "Position"; }
  std::int64_t Components() const { return this->Velocity.Options.InputChannels; }
  /// One line: what is generated, network, noise.
  std::string Description() const;
};

/// From the caller's coordinates to the network's, exactly: the 1e-8 that published networks add to the scale (see
/// InputNormalisation::SurfaceArea) would leave small surfaces, such as a cell of 1e-6 m, with another area than 1.
/// @throws InvalidInput when the mesh has no extent.
MeshNormalisation FlowNormalisation(const TriangleMesh& mesh);

/// Reads a model file: safetensors with the metadata `architecture` ("flow_matching"), `format_version` ("1"),
/// `flow_matching` (a JSON object), and the networks `velocity` and, in some, `encoder` as in ReadPartNetwork().
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a weight is
/// not finite; ModelMismatch when it is another kind of model, naming what was found and what was expected.
FlowMatchingModel ReadFlowMatchingModel(const std::string& path);

/// @throws InvalidInput when the networks do not fit together, or numbers are out of their range.
void CheckModel(const FlowMatchingModel& model);

/// Writes a model file in float32. @throws InvalidInput as CheckModel(), and when the file cannot be written.
void WriteFlowMatchingModel(const std::string& path, const FlowMatchingModel& model);

} // namespace surfsynth
