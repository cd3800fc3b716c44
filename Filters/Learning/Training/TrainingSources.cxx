// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TrainingSources.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"
#include "Inference/PoissonNet/MeshNormalization.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/TrainingOptions.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace surfsynth
{

namespace
{
/// Fields that the scale of the noise is measured on.
constexpr std::uint32_t FieldsMeasured = 64;
/// The stream of those fields, apart from those of the training.
constexpr std::uint32_t MeasuringStream = 0xffffffff;

using SampleMap = Eigen::Map<SignalSamples>;

/// Sample @p number as [V, C].
SampleMap SampleOf(SignalSamples& samples, Eigen::Index number, std::int64_t components)
{
  return { samples.row(number).data(), samples.cols() / components, components };
}

/// Mean over surface and components of the square, weighted by @p mass.
template <typename Values>
double MeanSquare(const Values& values, const Eigen::VectorXd& mass)
{
  return (mass.transpose() * values.template cast<double>().cwiseAbs2()).sum() /
    (mass.sum() * static_cast<double>(values.cols()));
}

/// Positions lose their mean over the surface, and are scaled as their source is.
void NormalizePositions(SignalSamples& samples, const Eigen::VectorXd& mass, double scale)
{
  for (Eigen::Index n = 0; n < samples.rows(); ++n)
  {
    SampleMap sample = SampleOf(samples, n, 3);
    const Eigen::RowVectorXd mean = mass.transpose() * sample.cast<double>() / mass.sum();
    sample = ((sample.cast<double>().rowwise() - mean) / scale).cast<float>();
  }
}

/// Mean and standard deviation of each component over all samples, each surface with the weight of its samples.
void MeasureSignal(TrainingSources& prepared)
{
  const std::int64_t components = prepared.Components;
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(components);
  Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(components);
  double count = 0.0;
  for (TrainingSource& source : prepared.Sources)
  {
    const Eigen::VectorXd mass = source.VertexMass.cast<double>() / source.VertexMass.cast<double>().sum();
    for (Eigen::Index n = 0; n < source.Samples.rows(); ++n)
    {
      const Eigen::MatrixXd sample = SampleOf(source.Samples, n, components).cast<double>();
      sum += mass.transpose() * sample;
      squares += mass.transpose() * sample.cwiseAbs2();
    }
    count += static_cast<double>(source.Samples.rows());
  }
  prepared.Frame.SignalMean = sum / count;
  const Eigen::RowVectorXd variance = squares / count - prepared.Frame.SignalMean.cwiseAbs2();
  for (Eigen::Index c = 0; c < variance.size(); ++c)
  {
    if (!(variance[c] > 1e-12 * squares[c] / count))
    {
      throw InvalidInput("FlowMatchingTrainer: component " + std::to_string(c) +
        " of the signal is the same number everywhere; expected samples that vary.");
    }
  }
  prepared.Frame.SignalScale = variance.cwiseSqrt();
}

void NormalizeSignal(TrainingSources& prepared)
{
  const Eigen::RowVectorXf mean = prepared.Frame.SignalMean.cast<float>();
  const Eigen::RowVectorXf factor = prepared.Frame.SignalScale.cwiseInverse().cast<float>();
  for (TrainingSource& source : prepared.Sources)
  {
    for (Eigen::Index n = 0; n < source.Samples.rows(); ++n)
    {
      SampleMap sample = SampleOf(source.Samples, n, prepared.Components);
      sample = ((sample.rowwise() - mean).array().rowwise() * factor.array()).matrix();
    }
  }
}

/// Centre of the samples on @p source: their mean; for a single sample, the surface itself or 0.
Eigen::MatrixXd CenterOf(TrainingSource& source, std::int64_t components, bool positions)
{
  const Eigen::Index count = source.Samples.rows();
  if (count == 1 && positions)
  {
    return source.Condition.leftCols(3).cast<double>();
  }
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(source.Samples.cols() / components, components);
  for (Eigen::Index n = 0; count > 1 && n < count; ++n)
  {
    sum += SampleOf(source.Samples, n, components).cast<double>();
  }
  return sum / static_cast<double>(count);
}

/// The variance of the samples on their surfaces, in the mean over these and the components.
double VarianceOf(TrainingSources& prepared)
{
  double sum = 0.0;
  double squares = 0.0;
  Eigen::Index degrees = 0; // of freedom
  for (TrainingSource& source : prepared.Sources)
  {
    const Eigen::VectorXd mass = source.VertexMass.cast<double>();
    const Eigen::MatrixXd center = CenterOf(source, prepared.Components, prepared.Frame.GeneratesPositions());
    for (Eigen::Index n = 0; n < source.Samples.rows(); ++n)
    {
      const SampleMap sample = SampleOf(source.Samples, n, prepared.Components);
      sum += MeanSquare(sample.cast<double>() - center, mass);
      squares += MeanSquare(sample, mass);
    }
    degrees += std::max<Eigen::Index>(source.Samples.rows() - 1, 1);
  }
  if (!(sum > 1e-12 * squares)) // of float32 numbers
  {
    throw InvalidInput("FlowMatchingTrainer: the samples on a surface are all the same; expected samples that vary, or "
                       "a noise scale above 0.");
  }
  return sum / static_cast<double>(degrees);
}

/// Mean square of fields of @p noise of scale 1 on a surface.
double FieldSquares(const FlowNoiseField& noise, const Eigen::VectorXd& mass, bool positions, std::uint64_t seed)
{
  SampleRequest request;
  request.Seed = seed;
  request.NumberOfSamples = FieldsMeasured;
  request.Stream = MeasuringStream;
  Eigen::MatrixXd fieldValues(mass.size(), FieldsMeasured);
  noise.SampleInto(request, [&](std::uint32_t field) { return fieldValues.col(field).data(); });
  if (positions) // whose noise loses its mean
  {
    fieldValues.rowwise() -= (mass.transpose() * fieldValues / mass.sum()).eval();
  }
  return MeanSquare(fieldValues, mass);
}

/// The scale that gives fields the variance of the samples, in the mean over the surfaces, each of area 1.
double MatchingScale(TrainingSources& prepared)
{
  const double samples = VarianceOf(prepared);
  double squares = 0.0;
  for (const TrainingSource& source : prepared.Sources)
  {
    squares += source.NoiseSquares;
  }
  return std::sqrt(samples / (squares / static_cast<double>(prepared.Sources.size())));
}

/// Root mean square of the samples, of positions relative to their surfaces.
double DeviationOf(TrainingSources& prepared)
{
  double squares = 0.0;
  Eigen::Index count = 0;
  for (TrainingSource& source : prepared.Sources)
  {
    const Eigen::VectorXd mass = source.VertexMass.cast<double>();
    const auto surface = source.Condition.leftCols(3);
    for (Eigen::Index n = 0; n < source.Samples.rows(); ++n)
    {
      const FeatureMatrix sample = SampleOf(source.Samples, n, prepared.Components);
      squares += MeanSquare(prepared.Frame.GeneratesPositions() ? FeatureMatrix(sample - surface) : sample, mass);
    }
    count += source.Samples.rows();
  }
  return std::sqrt(squares / static_cast<double>(count));
}

ShapeMoments MomentsOf(const std::vector<Eigen::Matrix<double, 1, 6>>& surfaces)
{
  ShapeMoments shape;
  for (const auto& moments : surfaces)
  {
    shape.Mean += moments / static_cast<double>(surfaces.size());
  }
  for (const auto& moments : surfaces)
  {
    shape.Spread = std::max(shape.Spread, MomentDistance(shape.Mean, moments));
  }
  return shape;
}

FeatureMatrix ConditionOf(
  const PoissonNetModel* encoder, const PoissonOperators& operators, const TriangleMesh& mesh, const Progress& progress)
{
  FeatureMatrix condition = mesh.Points.cast<float>();
  if (encoder)
  {
    const PoissonShift shift = encoder->Options.Shift;
    const PoissonNetEvaluator evaluator(std::make_shared<const PoissonNetModel>(*encoder),
      shift == operators.Shift ? operators : BuildPoissonOperators(mesh, MeshTopology(mesh), progress, shift),
      mesh.Points);
    const FeatureMatrix encoding = evaluator.Evaluate({}, progress).Values;
    condition.conservativeResize(Eigen::NoChange, 3 + encoding.cols());
    condition.rightCols(encoding.cols()) = encoding;
  }
  return condition;
}

/// What the preparation of each surface depends on.
struct Preparation
{
  const FlowMatchingModel& Frame; ///< with encoder, and noise smoothed in the network's units
  bool MeasuresNoise;             ///< on each surface, for its scale
  std::uint64_t Seed;             ///< of the fields that are measured
  const FactorConsumer& Keep;
};

/// Condition and measures of one surface, whose samples stay in the caller's units but for positions.
/// @param source its surface is in the network's coordinates. @param scale that it was divided by
/// @param factors receives what belongs to the surface
TrainingSource PrepareSource(
  SignalSource source, double scale, const Preparation& how, SourceFactors& factors, const Progress& progress)
{
  const FlowMatchingModel& frame = how.Frame;
  const bool positions = frame.GeneratesPositions();
  factors = BuildFactors(source.Mesh, frame.Noise, SubProgress(progress, 0.0, 0.8));
  TrainingSource prepared;
  prepared.Mesh = std::move(source.Mesh);
  prepared.VertexMass = factors.Operators.VertexMass;
  prepared.Condition = ConditionOf(
    frame.Encoder ? &*frame.Encoder : nullptr, factors.Operators, prepared.Mesh, SubProgress(progress, 0.8, 1.0));
  prepared.Samples = std::move(source.Samples);
  const Eigen::VectorXd mass = prepared.VertexMass.cast<double>();
  if (positions)
  {
    NormalizePositions(prepared.Samples, mass, scale);
  }
  if (how.MeasuresNoise)
  {
    prepared.NoiseSquares = FieldSquares(*factors.Noise, mass, positions, how.Seed);
  }
  return prepared;
}

/// Calls @p work for the number of each source; its errors then say which one it is of.
template <typename Work>
void ForEachSource(std::size_t count, const Work& work)
{
  for (std::size_t k = 0; k < count; ++k)
  {
    try
    {
      work(k);
    }
    catch (const InvalidInput& error)
    {
      throw InvalidInput("Source " + std::to_string(k) + " of the dataset: " + error.what());
    }
  }
}

/// Checks the surfaces of @p dataset and moves them to the network's coordinates. @returns the scale of each.
std::vector<double> NormalizeSurfaces(SignalDataset& dataset)
{
  std::vector<double> scales;
  ForEachSource(dataset.Sources.size(), [&](std::size_t k) {
    TriangleMesh& mesh = dataset.Sources[k].Mesh;
    RequireValidMesh(mesh, FlowMatchingSampler::Requirements());
    const MeshNormalization normalization = FlowNormalization(mesh);
    mesh = Normalized(std::move(mesh), normalization);
    scales.push_back(normalization.Scale);
  });
  return scales;
}

/// Mean over the surfaces, each of area 1, of the squared mean lengths of their edges.
double MeanSquaredEdge(const SignalDataset& dataset)
{
  double sum = 0.0;
  for (const SignalSource& source : dataset.Sources)
  {
    sum += std::pow(MeanSideLength(source.Mesh), 2);
  }
  return sum / static_cast<double>(dataset.Sources.size());
}

/// Turns the smoothing of the noise into the network's units, those of @p dataset.
void ChooseSmoothing(FlowMatchingModel& frame, const SignalDataset& dataset)
{
  const double edges = frame.Noise.Smoothing >= 0.0 ? frame.Noise.Smoothing
                                                    : DefaultSmoothing(frame.GeneratesPositions());
  frame.Noise.Smoothing = edges * MeanSquaredEdge(dataset);
}

/// Prepares all surfaces one by one, and returns their second moments.
/// @param dataset surfaces in the network's coordinates, divided by @p scales
std::vector<Eigen::Matrix<double, 1, 6>> PrepareAll(SignalDataset& dataset, const std::vector<double>& scales,
  const Preparation& how, TrainingSources& prepared, const Progress& progress)
{
  std::vector<Eigen::Matrix<double, 1, 6>> moments;
  const auto count = static_cast<double>(dataset.Sources.size());
  ForEachSource(dataset.Sources.size(), [&](std::size_t k) {
    moments.push_back(SecondMoments(dataset.Sources[k].Mesh));
    const auto done = static_cast<double>(k);
    SourceFactors factors;
    prepared.Sources.push_back(PrepareSource(std::move(dataset.Sources[k]), scales[k], how, factors,
      SubProgress(progress, done / count, (done + 1.0) / count)));
    how.Keep(k, prepared.Sources.back(), std::move(factors));
  });
  return moments;
}

/// Units of the signal, noise and encoder of a training that goes on from @p initial.
/// @throws InvalidInput when the signal is another one.
FlowMatchingModel FrameOf(const FlowMatchingModel& initial, const SignalDataset& dataset)
{
  CheckModel(initial);
  if (initial.SignalName != dataset.SignalName || initial.Components() != dataset.NumberOfComponents())
  {
    throw InvalidInput("FlowMatchingTrainer: the dataset has the signal \"" + dataset.SignalName + "\", " +
      std::to_string(dataset.NumberOfComponents()) + " components; expected that of the initial model, \"" +
      initial.SignalName + "\", " + std::to_string(initial.Components()) + ".");
  }
  FlowMatchingModel frame = initial;
  frame.Temperature = 1.0; // that of other weights
  frame.Velocity = {};
  return frame;
}

/// Takes over where the data come from, and their license, into the metadata of the model.
void AddProvenance(FlowMatchingModel& frame, const SignalDataset& dataset)
{
  const std::pair<const char*, const std::string*> texts[] = { { "origin", &dataset.Origin },
    { "license", &dataset.License } };
  for (const auto& [key, text] : texts)
  {
    if (!text->empty())
    {
      frame.Metadata[key] = *text;
    }
  }
}

/// Makes values of the signal, noise and network alike in size, and says in the frame how.
void ChooseUnits(TrainingSources& prepared, double noiseScale)
{
  if (prepared.Frame.GeneratesPositions())
  {
    prepared.Frame.SignalMean = Eigen::RowVectorXd::Zero(3);
    prepared.Frame.SignalScale = Eigen::RowVectorXd::Ones(3);
  }
  else
  {
    MeasureSignal(prepared);
    NormalizeSignal(prepared);
  }
  const double deviation = DeviationOf(prepared);
  prepared.Frame.DataDeviation = deviation > 0.0 ? deviation : 1.0;
  if (noiseScale == 0.0)
  {
    prepared.Frame.Noise.Scale = MatchingScale(prepared);
  }
}
} // namespace

SourceFactors BuildFactors(const TriangleMesh& mesh, const FlowNoise& noise, const Progress& progress)
{
  const MeshTopology topology(mesh);
  SourceFactors factors;
  factors.Operators = BuildPoissonOperators(mesh, topology, SubProgress(progress, 0.0, 0.5), ShiftOfTrainings);
  factors.NoiseOptions = noise;
  factors.Noise = std::make_unique<FlowNoiseField>(mesh, topology, noise, SubProgress(progress, 0.5, 1.0));
  return factors;
}

TrainingSources PrepareSources(SignalDataset dataset, const FlowMatchingModel* initial, const PoissonNetModel* encoder,
  bool withoutEncoder, const FlowNoise& noise, std::uint64_t seed, const FactorConsumer& keep, const Progress& progress)
{
  CheckDataset(dataset);
  TrainingSources prepared;
  prepared.Components = dataset.NumberOfComponents();
  if (initial)
  {
    prepared.Frame = FrameOf(*initial, dataset);
  }
  else
  {
    prepared.Frame.SignalName = dataset.SignalName;
    prepared.Frame.Noise = noise;
  }
  if (encoder)
  {
    prepared.Frame.Encoder = *encoder;
  }
  AddProvenance(prepared.Frame, dataset);
  const std::vector<double> scales = NormalizeSurfaces(dataset);
  if (!initial)
  {
    ChooseSmoothing(prepared.Frame, dataset);
  }
  const Preparation how = { prepared.Frame, !initial && noise.Scale == 0.0, seed, keep };
  prepared.Frame.Shape = MomentsOf(PrepareAll(dataset, scales, how, prepared, progress));
  if (!prepared.Frame.Encoder && !withoutEncoder && prepared.Frame.Shape.Spread > FlowMatchingSampler::MomentTolerance)
  {
    throw InvalidInput("FlowMatchingTrainer: the " + std::to_string(dataset.Sources.size()) +
      " surfaces have different shapes (their second moments differ by " + FormatNumber(prepared.Frame.Shape.Spread) +
      " of their trace); expected one shape, or an encoder that tells the network where on a surface it is: "
      "vtkFlowMatchingTrainer trains one with EncoderIterations, \"surfacesynthesis-train encoding\" without VTK. "
      "WithoutEncoder trains without, for comparison.");
  }
  if (!initial)
  {
    ChooseUnits(prepared, noise.Scale);
  }
  else if (!prepared.Frame.GeneratesPositions())
  {
    NormalizeSignal(prepared);
  }
  return prepared;
}

std::uint64_t ContentHash(const SignalDataset& dataset)
{
  std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a, over 32-bit words
  const auto mix = [&hash](std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3; };
  for (const char letter : dataset.SignalName) // what is made of the numbers depends on it
  {
    mix(static_cast<unsigned char>(letter));
  }
  for (const SignalSource& source : dataset.Sources)
  {
    mix(ContentHash(source.Mesh));
    mix(static_cast<std::uint64_t>(source.Samples.rows()));
    for (Eigen::Index k = 0; k < source.Samples.size(); ++k)
    {
      std::uint32_t word;
      std::memcpy(&word, source.Samples.data() + k, sizeof word);
      mix(word);
    }
  }
  return hash;
}

} // namespace surfsynth
