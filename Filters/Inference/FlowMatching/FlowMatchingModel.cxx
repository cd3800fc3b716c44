// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FlowMatching/FlowMatchingModel.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Operators/SurfaceOperators.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"
#include "Inference/Common/ModelFile.h"

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr const char* FlowMatchingArchitecture = "flow_matching";
constexpr const char* FlowKey = "flow_matching";

const std::pair<const char*, NoiseModel> NoiseNames[] = { { "matern", NoiseModel::Matern },
  { "per_vertex", NoiseModel::PerVertex }, { "white", NoiseModel::White }, { "unscreened", NoiseModel::Unscreened },
  { "spectral", NoiseModel::Spectral } };

/// Names of predictions in model files.
const std::pair<const char*, FlowPrediction> PredictionNames[] = { { "velocity", FlowPrediction::Velocity },
  { "data", FlowPrediction::Data }, { "preconditioned", FlowPrediction::Preconditioned } };

/// Version of the format of models that predict no velocities, which earlier versions of the library would misread.
constexpr const char* DataFormatVersion = "2";

template <typename Value, std::size_t Count>
const char* NameOf(Value value, const std::pair<const char*, Value> (&names)[Count])
{
  return std::find_if(std::begin(names), std::end(names), [&](const auto& n) { return n.second == value; })->first;
}

/// The value that @p name stands for; the reader fails with @p expected for the value of @p key where there is none.
template <typename Value, std::size_t Count>
Value ValueOf(const std::string& name, const std::pair<const char*, Value> (&names)[Count],
  const DescriptionReader& reader, const char* key, const char* expected)
{
  const auto found = std::find_if(std::begin(names), std::end(names), [&](const auto& n) { return name == n.first; });
  if (found == std::end(names))
  {
    reader.Fail(key, expected);
  }
  return found->second;
}

/// "1 block", "2 blocks"
std::string Counted(std::int64_t number, const std::string& thing)
{
  return std::to_string(number) + " " + thing + (number == 1 ? "" : "s");
}

/// Key of the smoothing. Earlier versions wrote "noise_smoothing" for each kind of noise, and smoothed Matern noise only.
const char* SmoothingKey(NoiseModel model) { return model == NoiseModel::Matern ? "noise_smoothing" : "smoothing"; }

NoiseModel ReadNoise(const DescriptionReader& reader)
{
  return ValueOf(
    reader.String("noise"), NoiseNames, reader, "noise", "matern, per_vertex, white, unscreened or spectral");
}

FlowPrediction ReadPrediction(const DescriptionReader& reader)
{
  return ValueOf(reader.StringOr("prediction", "velocity"), PredictionNames, reader, "prediction",
    "velocity, data or preconditioned");
}

Eigen::RowVectorXd ReadRow(const DescriptionReader& reader, const char* key)
{
  const std::vector<double> numbers = reader.Numbers(key);
  return Eigen::Map<const Eigen::RowVectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

void RequireKnownTensors(const SafetensorsFile& file, bool encoder)
{
  for (const auto& entry : file.Tensors())
  {
    const std::string& name = entry.first;
    if (name.rfind("velocity.", 0) != 0 && !(encoder && name.rfind("encoder.", 0) == 0))
    {
      throw ModelMismatch(file.Name() + ": the tensor \"" + name +
        "\" does not belong to a flow matching model; expected names that begin with \"velocity.\" or, where the "
        "metadata describe one, \"encoder.\".");
    }
  }
}

[[noreturn]] void RefuseFlow(const std::string& found, const std::string& expected)
{
  throw InvalidInput("FlowMatchingModel: " + found + "; expected " + expected + ".");
}

void CheckNetworks(const FlowMatchingModel& model)
{
  const PoissonNetOptions& velocity = model.Velocity.Options;
  std::int64_t conditions = FlowMatchingModel::PlainConditions;
  if (model.Encoder)
  {
    const PoissonNetOptions& encoder = model.Encoder->Options;
    if (encoder.InputChannels != 3 || encoder.ExtraFeatures != 0 || encoder.Domain != PoissonNetDomain::Vertices)
    {
      RefuseFlow("the encoder takes " + std::to_string(encoder.InputChannels) + " channels and " +
          std::to_string(encoder.ExtraFeatures) + " conditions",
        "3 channels, no condition, and predictions at the vertices");
    }
    conditions += encoder.ResultChannels();
  }
  if (velocity.ExtraFeatures != conditions)
  {
    RefuseFlow("the velocity takes " + std::to_string(velocity.ExtraFeatures) + " conditions",
      std::to_string(conditions) + ": time, position and what the encoder gives");
  }
  if (velocity.ResultChannels() != velocity.InputChannels || velocity.Domain != PoissonNetDomain::Vertices ||
    velocity.Activation != LastActivation::Identity)
  {
    RefuseFlow("the velocity gives " + std::to_string(velocity.ResultChannels()) + " channels for a signal of " +
        std::to_string(velocity.InputChannels),
      "as many, at the vertices and without a last activation");
  }
  if (model.GeneratesPositions() && velocity.InputChannels != 3)
  {
    RefuseFlow("positions have " + std::to_string(velocity.InputChannels) + " channels", "3");
  }
}

/// Integrals over a surface.
struct Integrals
{
  double Area = 0.0;
  Eigen::RowVector3d First = Eigen::RowVector3d::Zero(); ///< of x
  Eigen::Matrix3d Second = Eigen::Matrix3d::Zero();      ///< of x x^T
};

/// Integrals of positions x relative to @p origin.
Integrals IntegralsAbout(const TriangleMesh& mesh, const Eigen::RowVector3d& origin)
{
  const Eigen::VectorXd areas = FaceAreas(mesh);
  Integrals integrals;
  integrals.Area = areas.sum();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k)
    {
      corners.row(k) = mesh.Points.row(mesh.Triangles(f, k)) - origin;
    }
    const Eigen::RowVector3d sum = corners.colwise().sum();
    integrals.First += areas[f] / 3.0 * sum;
    // The integral of x x^T over a triangle is area / 12 (sum of p p^T + s s^T), s the sum of its corners.
    integrals.Second += areas[f] / 12.0 * (corners.transpose() * corners + sum.transpose() * sum);
  }
  return integrals;
}

Eigen::Matrix<double, 1, 6> RowOf(const Eigen::Matrix3d& moments)
{
  Eigen::Matrix<double, 1, 6> row;
  row << moments(0, 0), moments(0, 1), moments(0, 2), moments(1, 1), moments(1, 2), moments(2, 2);
  return row;
}
} // namespace

const char* NameOf(FlowPrediction prediction) { return NameOf(prediction, PredictionNames); }

double InputFactor(double time) { return 1.0 / std::hypot(1.0 - time, time); }

double RemainingTime(double time) { return std::max(1.0 - time, 0.02); }

MaternFieldOptions FieldOptions(const FlowNoise& noise)
{
  MaternFieldOptions options;
  options.Model = noise.Model;
  options.Mode = ScaleMode::Screening;
  options.Screening = noise.Screening;
  options.NumberOfEigenpairs = static_cast<Index>(noise.Eigenpairs);
  return options;
}

Eigen::Matrix<double, 1, 6> SecondMoments(const TriangleMesh& mesh)
{
  // A point of the mesh as the origin keeps digits far from that of the coordinates.
  const Integrals integrals = IntegralsAbout(mesh, mesh.Points.row(mesh.Triangles(0, 0)));
  const Eigen::RowVector3d centroid = integrals.First / integrals.Area;
  return RowOf(integrals.Second / integrals.Area - centroid.transpose() * centroid) / integrals.Area;
}

Eigen::Matrix<double, 1, 6> PartMoments(const TriangleMesh& part)
{
  return RowOf(IntegralsAbout(part, Eigen::RowVector3d::Zero()).Second);
}

double MomentExcess(const Eigen::Matrix<double, 1, 6>& whole, const Eigen::Matrix<double, 1, 6>& part)
{
  const Eigen::Matrix<double, 1, 6> m = part - whole;
  Eigen::Matrix3d difference;
  difference << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(difference, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().maxCoeff() / (whole[0] + whole[3] + whole[5]);
}

double MomentDistance(const Eigen::Matrix<double, 1, 6>& expected, const Eigen::Matrix<double, 1, 6>& found)
{
  const Eigen::Matrix<double, 1, 6> difference = (found - expected).cwiseAbs2();
  const double squares = difference[0] + difference[3] + difference[5] +
    2.0 * (difference[1] + difference[2] + difference[4]);
  return std::sqrt(squares) / (expected[0] + expected[3] + expected[5]);
}

MeshNormalization FlowNormalization(const TriangleMesh& mesh)
{
  return ComputeNormalization(mesh, InputNormalization::SurfaceArea);
}

MeshNormalization FlowNormalization(double area, const Eigen::RowVector3d& center)
{
  if (!(area > 0.0) || !std::isfinite(area) || !center.allFinite())
  {
    throw InvalidInput("FlowNormalization: the area is " + FormatNumber(area) + " and the center (" +
      FormatNumber(center[0]) + ", " + FormatNumber(center[1]) + ", " + FormatNumber(center[2]) +
      "); expected a finite area above 0 and a finite center.");
  }
  return { center, std::sqrt(area) };
}

std::string FlowMatchingModel::Description() const
{
  const PoissonNetOptions& options = this->Velocity.Options;
  const std::string signal = this->GeneratesPositions()
    ? "deformations"
    : "\"" + this->SignalName + "\", " + Counted(this->Components(), "component");
  return signal + " from " + NameOf(this->Noise.Model, NoiseNames) + " noise; " + Counted(options.Blocks, "block") +
    " of width " + std::to_string(options.Width) + (this->Encoder ? ", for many surfaces" : ", for one surface") +
    "; " + Counted(this->Iterations, "iteration") + " of training" +
    (this->Temperature == 1.0 ? "" : "; temperature " + FormatNumber(this->Temperature));
}

FlowMatchingModel ReadFlowMatchingModel(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireArchitecture(
    file, FlowMatchingArchitecture, "a flow matching model, as vtkFlowMatchingTrainer writes it", DataFormatVersion);
  const DescriptionReader reader(file, FlowKey);
  FlowMatchingModel model;
  model.Metadata = file.Metadata();
  model.SignalName = reader.String("signal_name");
  model.SignalMean = ReadRow(reader, "signal_mean");
  model.SignalScale = ReadRow(reader, "signal_scale");
  model.Noise.Model = ReadNoise(reader);
  model.Noise.Screening = reader.Number("noise_screening");
  model.Noise.Eigenpairs = reader.WholeNumber("noise_eigenpairs");
  model.Noise.Scale = reader.Number("noise_scale");
  model.Noise.Smoothing = reader.NumberOr(SmoothingKey(model.Noise.Model), 0.0);
  model.Prediction = ReadPrediction(reader);
  model.DataDeviation = reader.NumberOr("data_deviation", 1.0);
  model.Temperature = reader.NumberOr("temperature", 1.0);
  model.Iterations = reader.WholeNumber("iterations");
  model.Shape.Spread = reader.Number("shape_spread");
  const Eigen::RowVectorXd moments = ReadRow(reader, "shape_moments");
  if (moments.size() != 6)
  {
    throw ModelMismatch(path + ": \"shape_moments\" has " + std::to_string(moments.size()) + " numbers; expected 6.");
  }
  model.Shape.Mean = moments;
  const bool encoder = file.Metadata().count("encoder") != 0;
  RequireKnownTensors(file, encoder);
  model.Velocity = ReadPartNetwork(file, "velocity");
  if (encoder)
  {
    model.Encoder = ReadPartNetwork(file, "encoder");
  }
  try
  {
    CheckModel(model);
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(path + ": " + error.what());
  }
  return model;
}

void CheckModel(const FlowMatchingModel& model)
{
  CheckModel(model.Velocity);
  if (model.Encoder)
  {
    CheckModel(*model.Encoder);
  }
  CheckNetworks(model);
  if (model.SignalMean.size() != model.Components() || model.SignalScale.size() != model.Components() ||
    !model.SignalMean.allFinite() || !model.SignalScale.allFinite() || !(model.SignalScale.array() > 0.0).all())
  {
    RefuseFlow("mean and scale of the signal have " + std::to_string(model.SignalMean.size()) + " and " +
        std::to_string(model.SignalScale.size()) + " numbers",
      std::to_string(model.Components()) + " finite ones each, the scales above 0");
  }
  const FlowNoise& noise = model.Noise;
  if (!(noise.Smoothing >= 0.0) || !std::isfinite(noise.Smoothing))
  {
    RefuseFlow("the smoothing of the noise is " + FormatNumber(noise.Smoothing), "a finite number, at least 0");
  }
  if (!(noise.Screening > 0.0) || !(noise.Scale > 0.0) || !std::isfinite(noise.Screening * noise.Scale) ||
    noise.Eigenpairs < 1 || noise.Eigenpairs > 1000000)
  {
    RefuseFlow("the noise has screening " + FormatNumber(noise.Screening) + ", scale " + FormatNumber(noise.Scale) +
        " and " + std::to_string(noise.Eigenpairs) + " eigenpairs",
      "numbers above 0 and at most 1e6 eigenpairs");
  }
  if (!(model.DataDeviation > 0.0) || !std::isfinite(model.DataDeviation))
  {
    RefuseFlow("the deviation of the data is " + FormatNumber(model.DataDeviation), "a finite number above 0");
  }
  if (!(model.Temperature >= 0.0) || !(model.Temperature <= 10.0))
  {
    RefuseFlow("the temperature is " + FormatNumber(model.Temperature), "a number from 0 to 10");
  }
  if (!model.Shape.Mean.allFinite() || !(model.Shape.Spread >= 0.0))
  {
    RefuseFlow("the moments of the shape are not finite", "finite moments and a spread of at least 0");
  }
}

void WriteFlowMatchingModel(const std::string& path, const FlowMatchingModel& model)
{
  CheckModel(model);
  std::map<std::string, TensorData> tensors;
  std::map<std::string, std::string> metadata = model.Metadata;
  AddPartNetwork("velocity", model.Velocity, tensors, metadata);
  metadata.erase("encoder");
  if (model.Encoder)
  {
    AddPartNetwork("encoder", *model.Encoder, tensors, metadata);
  }
  const auto numbers = [](const auto& row) { return std::vector<double>(row.data(), row.data() + row.size()); };
  metadata["architecture"] = FlowMatchingArchitecture;
  const bool predictsVelocity = model.Prediction == FlowPrediction::Velocity;
  metadata["format_version"] = predictsVelocity ? ModelFormatVersion : DataFormatVersion;
  metadata["producer"] = "SurfaceSynthesis";
  nlohmann::json description({ { "signal_name", model.SignalName }, { "signal_mean", numbers(model.SignalMean) },
    { "signal_scale", numbers(model.SignalScale) }, { "noise", NameOf(model.Noise.Model, NoiseNames) },
    { "noise_screening", model.Noise.Screening }, { "noise_eigenpairs", model.Noise.Eigenpairs },
    { "noise_scale", model.Noise.Scale }, { SmoothingKey(model.Noise.Model), model.Noise.Smoothing },
    { "iterations", model.Iterations }, { "shape_moments", numbers(model.Shape.Mean) },
    { "shape_spread", model.Shape.Spread } });
  if (!predictsVelocity)
  {
    description["prediction"] = NameOf(model.Prediction);
    description["data_deviation"] = model.DataDeviation;
  }
  if (model.Temperature != 1.0)
  {
    description["temperature"] = model.Temperature;
  }
  metadata[FlowKey] = description.dump();
  WriteSafetensors(path, tensors, metadata);
}

} // namespace surfsynth
