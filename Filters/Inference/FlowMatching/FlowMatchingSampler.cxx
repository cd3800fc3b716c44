// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Inference/FlowMatching/CoupledOffsets.h"
#include "Inference/FlowMatching/FlowNoiseField.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Limit of the state for noise with values up to @p noise. States of a trained flow are those of the noise at first and
/// near 1 at the end; beyond the limit the flow does not return.
float LargestState(float noise) { return 100.0F * std::max(noise, 10.0F); }

/// Largest number of corrections: the last one is at a flow time that leaves more than the least RemainingTime().
constexpr int MostCorrections = 20;

/// @throws InvalidInput always.
[[noreturn]] void RefuseUnbounded(const std::string& where)
{
  throw InvalidInput("FlowMatchingSampler: the state grows without bound " + where +
    "; expected a model that was trained on surfaces like this one. A surface with holes may need them closed "
    "(vtkSurfaceRepairFilter).");
}

/// @throws InvalidInput when a state is beyond its limit.
void RequireBounded(const FeatureMatrix& state, float largest, const std::string& where)
{
  if (!(state.cwiseAbs().maxCoeff() < largest))
  {
    RefuseUnbounded(where);
  }
}

using VelocityFunction = std::function<FeatureMatrix(const FeatureMatrix& state, double time)>;

/// Takes step @p k of @p request from @p state.
void Step(FeatureMatrix& state, int k, const FlowSampleRequest& request, const VelocityFunction& velocity)
{
  const auto step = static_cast<float>(1.0 / request.Steps);
  const double half = (k + 0.5) / request.Steps;
  const FeatureMatrix first = velocity(state, static_cast<double>(k) / request.Steps);
  switch (request.Integrator)
  {
    case FlowIntegrator::Euler:
      state += step * first;
      break;
    case FlowIntegrator::Midpoint:
      state += step * velocity(state + 0.5F * step * first, half);
      break;
    case FlowIntegrator::RungeKutta4:
    {
      const FeatureMatrix second = velocity(state + 0.5F * step * first, half);
      const FeatureMatrix third = velocity(state + 0.5F * step * second, half);
      const FeatureMatrix fourth = velocity(state + step * third, static_cast<double>(k + 1) / request.Steps);
      state += step / 6.0F * (first + 2.0F * second + 2.0F * third + fourth);
      break;
    }
  }
}

std::optional<PoissonNetEvaluator> MakeEvaluator(const std::shared_ptr<const FlowMatchingModel>& model,
  const PoissonNetModel& network, const PoissonOperators& operators, const PointMatrix& points)
{
  // Shares the ownership of the model that the network is a part of.
  return PoissonNetEvaluator(std::shared_ptr<const PoissonNetModel>(model, &network), operators, points);
}
} // namespace

int EvaluationsPerStep(FlowIntegrator integrator)
{
  return integrator == FlowIntegrator::Euler ? 1 : integrator == FlowIntegrator::Midpoint ? 2 : 4;
}

double CorrectionTime(int k, int corrections) { return 0.5 + 0.5 * (k + 1.0) / (corrections + 1.0); }

int SuitableCorrections(const FlowMatchingModel& model) { return model.Prediction == FlowPrediction::Data ? 2 : 0; }

class FlowMatchingSampler::Internals
{
public:
  Internals(std::shared_ptr<const FlowMatchingModel> model, const TriangleMesh& mesh, const MeshTopology& topology,
    const ComponentCoupling& coupling, const std::optional<MeshNormalization>& whole, const Progress& progress)
    : Model(std::move(model))
    , Normalization(whole ? *whole : FlowNormalization(mesh))
    , Coupling(ScaledCoupling(coupling, this->Normalization))
  {
    CheckModel(*this->Model);
    TriangleMesh normalized = Normalized(mesh, this->Normalization);
    const PoissonOperators operators = BuildPoissonOperators(
      normalized, topology, SubProgress(progress, 0.0, 0.45), this->Model->Velocity.Options.Shift, this->Coupling);
    this->IsCoupled = operators.Coupling != nullptr;
    if (this->IsCoupled && this->Model->GeneratesPositions())
    {
      TriangleMesh rounded = normalized; // as the operators have been built of
      rounded.Points = normalized.Points.cast<float>().cast<double>();
      this->Offsets.emplace(rounded, topology, this->Coupling, operators.Solver, SubProgress(progress, 0.45, 0.5));
    }
    this->VertexMass = operators.VertexMass.cast<double>();
    if (whole)
    {
      this->SourceMean = this->MeanOf(normalized.Points).cast<float>();
    }
    this->Describe(normalized, topology, whole.has_value());
    this->VelocityField = MakeEvaluator(this->Model, this->Model->Velocity, operators, normalized.Points);
    this->PrepareCondition(operators, normalized, topology, SubProgress(progress, 0.5, 0.6));
    this->Field = std::make_unique<FlowNoiseField>(
      std::move(normalized), topology, this->Model->Noise, SubProgress(progress, 0.6, 1.0), this->Coupling);
  }

  /// Mean over the surface of each component.
  Eigen::RowVectorXd MeanOf(const Eigen::MatrixXd& values) const
  {
    return this->VertexMass.transpose() * values / this->VertexMass.sum();
  }

  /// Subtracts the mean over the surface from each component.
  void RemoveMean(Eigen::MatrixXd& values) const { values.rowwise() -= this->MeanOf(values); }

  std::shared_ptr<const FlowMatchingModel> Model;
  MeshNormalization Normalization;
  ComponentCoupling Coupling; ///< in the network's coordinates
  bool IsCoupled = false;     ///< true where there are components to couple
  Eigen::VectorXd VertexMass;
  std::optional<Eigen::RowVector3f> SourceMean; ///< mean position of a part, in the network's coordinates
  std::optional<CoupledOffsets> Offsets;        ///< of components, where positions are generated
  std::optional<PoissonNetEvaluator> VelocityField;
  std::unique_ptr<FlowNoiseField> Field;
  FeatureMatrix Condition; ///< [V, 4 + E]: time, to be filled in, position, encoding
  std::vector<std::string> Warnings;

private:
  void Describe(const TriangleMesh& normalized, const MeshTopology& topology, bool isPart)
  {
    this->Warnings = DescribeUnlikelyInput(normalized, topology, InputNormalization::SurfaceArea);
    const double largest = this->Model->Shape.Spread + MomentTolerance;
    if (isPart)
    {
      const double excess = MomentExcess(this->Model->Shape.Mean, PartMoments(normalized));
      if (excess > largest)
      {
        this->Warnings.push_back(
          "The surface is no part of one that the model was trained on, or the area and center given "
          "for its normalization are those of another: its second moments exceed those of the "
          "training by " +
          FormatNumber(excess) + " of their trace, expected at most " + FormatNumber(largest) +
          ". Samples are unlikely to be good.");
      }
      return;
    }
    const double distance = MomentDistance(this->Model->Shape.Mean, SecondMoments(normalized));
    if (distance > largest)
    {
      this->Warnings.push_back("The surface is shaped or turned unlike those that the model was trained on: its second "
                               "moments differ by " +
        FormatNumber(distance) + " of their trace, expected at most " + FormatNumber(largest) +
        ". Samples are unlikely to be good; turn it as the training surface was (vtkTransformFilter), or train a model "
        "on "
        "it.");
    }
  }

  void PrepareCondition(
    const PoissonOperators& operators, const TriangleMesh& mesh, const MeshTopology& topology, const Progress& progress)
  {
    this->Condition = FeatureMatrix::Zero(mesh.NumberOfPoints(), this->Model->Velocity.Options.ExtraFeatures);
    this->Condition.middleCols(1, 3) = mesh.Points.cast<float>();
    if (this->Model->Encoder)
    {
      const PoissonShift shift = this->Model->Encoder->Options.Shift;
      const auto encoder = MakeEvaluator(this->Model, *this->Model->Encoder,
        shift == operators.Shift ? operators : BuildPoissonOperators(mesh, topology, progress, shift, this->Coupling),
        mesh.Points);
      const FeatureMatrix encoding = encoder->Evaluate({}, progress).Values;
      this->Condition.rightCols(encoding.cols()) = encoding;
    }
  }
};

FlowMatchingSampler::FlowMatchingSampler(std::shared_ptr<const FlowMatchingModel> model, const TriangleMesh& mesh,
  const MeshTopology* topology, const Progress& progress, const ComponentCoupling& coupling,
  const std::optional<MeshNormalization>& normalization)
{
  std::optional<MeshTopology> own;
  if (!topology)
  {
    topology = &own.emplace(RequireValidMesh(mesh, Requirements(coupling.IsOn)));
  }
  this->Impl = std::make_unique<Internals>(std::move(model), mesh, *topology, coupling, normalization, progress);
}

FlowMatchingSampler::~FlowMatchingSampler() = default;
FlowMatchingSampler::FlowMatchingSampler(FlowMatchingSampler&&) noexcept = default;
FlowMatchingSampler& FlowMatchingSampler::operator=(FlowMatchingSampler&&) noexcept = default;

FeatureMatrix FlowMatchingSampler::InitialNoise(const FlowSampleRequest& request, const Progress& progress) const
{
  if (!(request.Temperature >= 0.0) || !std::isfinite(request.Temperature))
  {
    throw InvalidInput("FlowMatchingSampler: a temperature of " + FormatNumber(request.Temperature) +
      "; expected a finite number, at least 0.");
  }
  SampleRequest sample;
  sample.Seed = request.Seed;
  sample.FirstSample = request.Sample;
  sample.Stream = request.Stream;
  sample.NumberOfComponents = static_cast<std::uint32_t>(this->Impl->Model->Components());
  sample.Scale = request.Temperature * this->Impl->Model->Temperature * this->Impl->Model->Noise.Scale;
  RowMatrix values(this->Impl->VertexMass.size(), this->Impl->Model->Components());
  this->Impl->Field->SampleInto(
    sample, [&values](std::uint32_t) { return values.data(); }, progress);
  Eigen::MatrixXd noise = values;
  if (this->Impl->Model->GeneratesPositions())
  {
    this->Impl->RemoveMean(noise);
  }
  return noise.cast<float>();
}

FeatureMatrix FlowMatchingSampler::Velocity(const FeatureMatrix& state, double time, const Progress& progress) const
{
  const FlowMatchingModel& model = *this->Impl->Model;
  PoissonNetInput input;
  input.Signal = state;
  input.Extra = this->Impl->Condition;
  input.Extra.col(0).setConstant(static_cast<float>(time));
  if (model.Prediction == FlowPrediction::Velocity)
  {
    if (this->Impl->IsCoupled && state.cols() == 3)
    {
      // The differences that lead straight to those of the source.
      input.CoupledSignal = -state;
      if (model.GeneratesPositions())
      {
        input.CoupledSignal += input.Extra.middleCols(1, 3);
      }
      input.CoupledSignal /= static_cast<float>(RemainingTime(time));
    }
    FeatureMatrix velocity = this->Impl->VelocityField->Evaluate(input, progress).Values;
    const bool hasMean = model.Velocity.Options.Head != PoissonNetHead::GradientDomain;
    if (this->Impl->SourceMean && model.GeneratesPositions() && !hasMean)
    {
      // A gradient-domain head gives velocities of mean 0 over the part, which in the training was over the whole.
      velocity.rowwise() += *this->Impl->SourceMean;
    }
    return velocity;
  }
  const auto at = static_cast<float>(time);
  const auto deviation = static_cast<float>(model.DataDeviation);
  const auto source = input.Extra.middleCols(1, 3);
  if (model.GeneratesPositions())
  {
    input.Signal -= at * source;
  }
  input.Signal *= static_cast<float>(InputFactor(time)) / deviation;
  FeatureMatrix output = this->Impl->VelocityField->Evaluate(input, progress).Values;
  if (model.Velocity.Options.Head == PoissonNetHead::GradientDomain)
  {
    output -= input.Signal;
  }
  const bool preconditioned = model.Prediction == FlowPrediction::Preconditioned;
  if (preconditioned)
  {
    output = static_cast<float>(InputFactor(time)) * (output + (2.0F * at - 1.0F) * input.Signal);
  }
  output *= deviation;
  if (model.GeneratesPositions())
  {
    output += source;
  }
  return preconditioned ? output : (output - state) / static_cast<float>(RemainingTime(time));
}

FeatureMatrix FlowMatchingSampler::Integrate(
  FeatureMatrix noise, const FlowSampleRequest& request, const Observer& observe, const Progress& progress) const
{
  if (request.Steps < 1)
  {
    throw InvalidInput("FlowMatchingSampler: " + std::to_string(request.Steps) + " steps; expected at least 1.");
  }
  if (request.Corrections < 0 || request.Corrections > MostCorrections)
  {
    throw InvalidInput("FlowMatchingSampler: " + std::to_string(request.Corrections) + " corrections; expected 0 to " +
      std::to_string(MostCorrections) + ".");
  }
  FeatureMatrix state = std::move(noise);
  const double evaluations = static_cast<double>(request.Steps) * EvaluationsPerStep(request.Integrator) +
    request.Corrections;
  const float largest = LargestState(state.size() > 0 ? state.cwiseAbs().maxCoeff() : 0.0F);
  int done = 0;
  const auto evaluated = [&](const FeatureMatrix& at, double time) {
    const Progress part = SubProgress(progress, done / evaluations, (done + 1) / evaluations);
    ++done;
    try
    {
      return this->Velocity(at, time, part);
    }
    catch (const NonFiniteOutput&)
    {
      RefuseUnbounded("at flow time " + FormatNumber(time));
    }
  };
  const VelocityFunction velocity = [&](const FeatureMatrix& at, double time) {
    RequireBounded(at, largest, "at flow time " + FormatNumber(time));
    return evaluated(at, time);
  };
  for (int k = 0; k < request.Steps; ++k)
  {
    if (observe)
    {
      observe(static_cast<double>(k) / request.Steps, state);
    }
    Step(state, k, request, velocity);
  }
  RequireBounded(state, largest, "at flow time 1");
  for (int k = 0; k < request.Corrections; ++k)
  {
    const double time = CorrectionTime(k, request.Corrections);
    state *= static_cast<float>(time);
    state += static_cast<float>(1.0 - time) * evaluated(state, time);
    RequireBounded(state, largest, "in correction " + std::to_string(k + 1));
  }
  if (this->Impl->Offsets)
  {
    PointMatrix positions = state.cast<double>();
    this->Impl->Offsets->Restore(positions);
    state = positions.cast<float>();
  }
  if (observe)
  {
    observe(1.0, state);
  }
  return state;
}

Eigen::MatrixXd FlowMatchingSampler::ToSignal(const FeatureMatrix& state) const
{
  const FlowMatchingModel& model = *this->Impl->Model;
  Eigen::MatrixXd signal = this->ToDeviation(state);
  signal.rowwise() += model.GeneratesPositions() ? Eigen::RowVectorXd(this->Impl->Normalization.Center)
                                                 : model.SignalMean;
  return signal;
}

Eigen::MatrixXd FlowMatchingSampler::ToDeviation(const FeatureMatrix& state) const
{
  const FlowMatchingModel& model = *this->Impl->Model;
  Eigen::MatrixXd deviation = state.cast<double>();
  if (model.GeneratesPositions())
  {
    return deviation * this->Impl->Normalization.Scale;
  }
  deviation.array().rowwise() *= model.SignalScale.array();
  return deviation;
}

FeatureMatrix FlowMatchingSampler::FromDeviation(const Eigen::MatrixXd& deviation) const
{
  const FlowMatchingModel& model = *this->Impl->Model;
  if (!model.GeneratesPositions())
  {
    return (deviation.array().rowwise() / model.SignalScale.array()).cast<float>();
  }
  Eigen::MatrixXd state = deviation / this->Impl->Normalization.Scale;
  this->Impl->RemoveMean(state);
  return state.cast<float>();
}

MeshRequirements FlowMatchingSampler::Requirements(bool coupled) { return PoissonNetEvaluator::Requirements(coupled); }

const std::vector<std::string>& FlowMatchingSampler::Warnings() const { return this->Impl->Warnings; }

const FlowMatchingModel& FlowMatchingSampler::Model() const { return *this->Impl->Model; }

} // namespace surfsynth
