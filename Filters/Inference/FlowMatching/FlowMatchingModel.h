// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A trained flow matching model [Kuai2026] [Lipman2023], and its file. No torch.
#pragma once

#include "Core/Mesh/TriangleMesh.h"
#include "Core/Noise/MaternField.h"
#include "Inference/PoissonNet/MeshNormalization.h"
#include "Inference/PoissonNet/PoissonNetModel.h"

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace surfsynth
{

/// Distribution of the signal at flow time 0, on the mesh in the network's coordinates (area 1).
struct FlowNoise
{
  NoiseModel Model = NoiseModel::Matern; ///< kind of the noise
  double Screening = 100.0;              ///< tau > 0 of Matern and Spectral; 100 in [Kuai2026]
  std::int64_t Eigenpairs = 256;         ///< number of eigenpairs of Spectral, at least 1
  double Scale = 1.0;                    ///< factor of every value
  double Smoothing = 0.0;                ///< s >= 0, see FlowNoiseField; 0 in [Kuai2026]
};

/// Quantity that the network of a flow matching model predicts. f_t is the state at time t, u the network's input and F(u)
/// its output.
enum class FlowPrediction
{
  Velocity, ///< the velocity: u = f_t, v = F(u), as published
  /// The data at the end of the flow, relative to the source surface s (0 for signals that are no positions):
  ///   u = (f_t - t s) / (d sqrt((1 - t)^2 + t^2)),   f_1 = s + d (F(u) - u),   v = (f_1 - f_t) / (1 - t),
  /// with d of FlowMatchingModel::DataDeviation, and F(u) instead of F(u) - u for a linear head. What the network does not
  /// change, such as relief, is that of the source.
  Data,
  /// A mixture of data and noise f_0 of the same size at all times, ((1 - t) (f_1 - s) - t f_0) / (d sqrt((1 - t)^2 + t^2)), in
  /// the same units and with the same u: the preconditioning of [Karras2022] for these flows, and the target of
  /// [Salimans2022]. With n = sqrt((1 - t)^2 + t^2):
  ///   f_1 = s + d (t u + (1 - t) F(u)) / n,   v = s + d (F(u) + (2 t - 1) u) / n,
  /// and F(u) - u instead of F(u) for a head that adds its input. Near the end of the flow data are what is there, but for a
  /// little of what the network predicts.
  Preconditioned
};

/// Name of @p prediction in model files: "velocity", "data" or "preconditioned".
const char* NameOf(FlowPrediction prediction);

/// Factor of the network's input with FlowPrediction::Data and Preconditioned at @p time, beside that of the deviation:
/// 1 / sqrt((1 - t)^2 + t^2).
double InputFactor(double time);

/// Time that is left at @p time, at least 0.02: what FlowPrediction::Data divides by.
double RemainingTime(double time);

/// Options of the MaternField that samples @p noise before it is scaled and smoothed.
MaternFieldOptions FieldOptions(const FlowNoise& noise);

/// Second moments xx, xy, xz, yy, yz, zz of the surfaces of the training, in the network's coordinates. They do not
/// depend on the triangulation, and show whether another surface is of the same kind.
struct ShapeMoments
{
  Eigen::Matrix<double, 1, 6> Mean = Eigen::Matrix<double, 1, 6>::Zero(); ///< mean over the surfaces
  double Spread = 0.0; ///< the largest MomentDistance() of a surface of the training from Mean
};

/// Second moments of @p mesh about its area-weighted centroid, over its area: [xx, xy, xz, yy, yz, zz].
Eigen::Matrix<double, 1, 6> SecondMoments(const TriangleMesh& mesh);

/// Frobenius norm of the difference of two second moments, over the trace of the first; 0 for the same shape in the
/// same orientation, about 1 for one that is turned by a right angle.
double MomentDistance(const Eigen::Matrix<double, 1, 6>& expected, const Eigen::Matrix<double, 1, 6>& found);

/// Second moments of @p part of a surface about the origin, [xx, xy, xz, yy, yz, zz]: the integral of x x^T. In the
/// coordinates of the whole surface, about its centroid and with area 1, no direction has more than SecondMoments() of the
/// whole.
Eigen::Matrix<double, 1, 6> PartMoments(const TriangleMesh& part);

/// Largest excess of the second moments of a part over those of the whole in any direction, over the trace of @p whole; at
/// most 0 for a part of that surface.
double MomentExcess(const Eigen::Matrix<double, 1, 6>& whole, const Eigen::Matrix<double, 1, 6>& part);

/// A velocity field on signals, F(f_t, t; condition), trained to carry noise to data: [Kuai2026], section 4.
///
/// The network's coordinates are those of the source surface moved to its centroid and scaled to area 1. Positions are
/// signals in those coordinates with mean 0; other signals are (value - SignalMean) / SignalScale. The condition of
/// each vertex is [t, position (3), encoding (channels of the encoder)].
struct FlowMatchingModel
{
  /// Number of channels of the condition before those of the encoder: time and position.
  static constexpr std::int64_t PlainConditions = 4;

  PoissonNetModel Velocity; ///< network that predicts the velocity F, or what Prediction says
  /// Network that predicts a positional encoding from positions, in models of many surfaces ([Kuai2026], section
  /// 5.1.2).
  std::optional<PoissonNetModel> Encoder;
  FlowNoise Noise;                                      ///< distribution at flow time 0
  FlowPrediction Prediction = FlowPrediction::Velocity; ///< what Velocity predicts
  double DataDeviation = 1.0;                           ///< d > 0 of FlowPrediction: root mean square of f_1 - s
  double Temperature = 1.0;                    ///< factor of the noise of samples, beside that of a request; 0 to 10
  std::string SignalName = "Position";         ///< "Position" for deformations
  Eigen::RowVectorXd SignalMean;               ///< [C]; 0 for positions
  Eigen::RowVectorXd SignalScale;              ///< [C], > 0; 1 for positions
  ShapeMoments Shape;                          ///< surfaces of the training
  std::int64_t Iterations = 0;                 ///< number of iterations of the training
  std::map<std::string, std::string> Metadata; ///< metadata of the file, unchanged

  /// True for a model of deformations.
  bool GeneratesPositions() const { return this->SignalName == "Position"; }
  /// Number of components of the signal, C.
  std::int64_t Components() const { return this->Velocity.Options.InputChannels; }
  /// Description in one line: signal, network, noise.
  std::string Description() const;
};

/// Computes the map from the caller's coordinates to the network's: to area 1, see InputNormalization::SurfaceArea.
/// @throws InvalidInput when the mesh has no extent.
MeshNormalization FlowNormalization(const TriangleMesh& mesh);
/// Map from the caller's coordinates to the network's for a part of a surface, or a damaged one: that of the whole surface
/// with @p area and @p center, its area-weighted centroid, in the caller's units.
/// @throws InvalidInput when the area is not a finite number above 0, or the center is not finite.
MeshNormalization FlowNormalization(double area, const Eigen::RowVector3d& center);
/// Former name of FlowNormalization().
[[deprecated("use FlowNormalization()")]] inline MeshNormalization FlowNormalisation(const TriangleMesh& mesh)
{
  return FlowNormalization(mesh);
}

/// Reads a model file: safetensors with the metadata `architecture` ("flow_matching"), `format_version` ("1", or "2"
/// where no velocity is predicted), `flow_matching` (a JSON object), and the networks `velocity` and, in some, `encoder` as in
/// ReadPartNetwork().
/// @throws InvalidInput when the file cannot be opened; FormatError when it breaks a rule of its format or a weight is
/// not finite; ModelMismatch when it is another kind of model.
FlowMatchingModel ReadFlowMatchingModel(const std::string& path);

/// Checks a model.
/// @throws InvalidInput when the networks do not fit together, or numbers are out of their range.
void CheckModel(const FlowMatchingModel& model);

/// Writes a model file in float32. @throws InvalidInput as CheckModel(), and when the file cannot be written.
void WriteFlowMatchingModel(const std::string& path, const FlowMatchingModel& model);

} // namespace surfsynth
