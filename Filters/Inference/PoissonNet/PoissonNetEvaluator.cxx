// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/PoissonNet/GradientStage.h"
#include "Inference/PoissonNet/VertexStage.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
std::string FormatSize(const FeatureMatrix& matrix)
{
  return "[" + std::to_string(matrix.rows()) + ", " + std::to_string(matrix.cols()) + "]";
}

/// log-softmax over each row.
void LogSoftmax(FeatureMatrix& logits)
{
  for (Eigen::Index row = 0; row < logits.rows(); ++row)
  {
    const Eigen::RowVectorXd shifted = (logits.row(row).array() - logits.row(row).maxCoeff()).cast<double>();
    logits.row(row) = (shifted.array() - std::log(shifted.array().exp().sum())).cast<float>();
  }
}
} // namespace

class PoissonNetEvaluator::Internals
{
public:
  Internals(std::shared_ptr<const PoissonNetModel> model, PoissonOperators operators, const PointMatrix& points)
    : Model(std::move(model))
    , Operators(std::move(operators))
    , Positions(points.cast<float>())
    , Weights(*this->Model)
    , Patches(std::make_shared<const FacePatches>(CutIntoPatches(this->Operators, points)))
    , Faces(this->Patches, this->Model->Options.Width)
    , Points(this->Operators.NumberOfPoints(), this->Model->Options.Width)
    , InverseArea(Eigen::VectorXf::Zero(this->Operators.NumberOfPoints()))
  {
    for (Index f = 0; f < this->Operators.NumberOfTriangles(); ++f)
    {
      for (int k = 0; k < 3; ++k)
      {
        this->InverseArea[this->Operators.Triangles(f, k)] += this->Operators.FaceAreas[f] / 3.0F;
      }
    }
    for (Index v = 0; v < this->Operators.NumberOfPoints(); ++v)
    {
      if (this->InverseArea[v] > 0.0F)
      {
        this->InverseArea[v] = 1.0F / this->InverseArea[v];
      }
      else
      {
        this->UnusedVertices.push_back(v);
      }
    }
  }

  std::int64_t NumberOfVertices() const { return this->Operators.NumberOfPoints(); }
  std::int64_t Width() const { return this->Model->Options.Width; }

  /// The condition after its MLP: one row for all vertices, or one for each.
  FeatureMatrix EmbedExtra(const FeatureMatrix& extra) const;
  void CheckInput(const PoissonNetInput& input) const;
  void RunBlock(const BlockWeights& block, const FeatureMatrix& extra, FeatureMatrix& features, FeatureMatrix& hidden,
    FeatureMatrix& products, SolverRows& rows, const Progress& progress) const;
  SolverRows::Channels SolutionChannels(const BlockWeights& block, const SolverRows& rows) const;
  void FinishProducts(const BlockWeights& block, FeatureMatrix& products) const;
  PoissonNetPrediction LinearOutput(const FeatureMatrix& features) const;
  PoissonNetPrediction GradientOutput(const FeatureMatrix& features, FeatureMatrix& hidden,
    const FeatureMatrix& positions, const FeatureMatrix& coupled, const Progress& progress) const;
  VertexFeatures Prepare(const ComplexMlpWeights& mlp, const FeatureMatrix& features, FeatureMatrix& hidden) const;
  SolverRows MakeRows(std::int64_t channels) const
  {
    return SolverRows(this->Operators.Solver, channels, this->Operators.VertexMass, this->UnusedVertices);
  }

  std::shared_ptr<const PoissonNetModel> Model;
  PoissonOperators Operators;
  FeatureMatrix Positions; ///< [V, 3], normalised
  InferenceWeights Weights;
  std::shared_ptr<const FacePatches> Patches;
  GradientStage Faces;
  VertexStage Points;
  Eigen::VectorXf InverseArea; ///< [V], one over a third of the area around, 0 for unused vertices
  std::vector<Index> UnusedVertices;
  MeshNormalization Normalization;
  std::vector<std::string> Warnings;
};

void PoissonNetEvaluator::Internals::CheckInput(const PoissonNetInput& input) const
{
  const PoissonNetOptions& options = this->Model->Options;
  const std::string vertices = std::to_string(this->NumberOfVertices());
  if (input.Signal.size() == 0 && options.InputChannels != 3)
  {
    throw InvalidInput("PoissonNetEvaluator: the model takes " + std::to_string(options.InputChannels) +
      " channels at each vertex; expected a signal, because positions have 3.");
  }
  if (input.Signal.size() != 0 &&
    (input.Signal.rows() != this->NumberOfVertices() || input.Signal.cols() != options.InputChannels))
  {
    throw InvalidInput("PoissonNetEvaluator: the signal is " + FormatSize(input.Signal) + "; expected [" + vertices +
      ", " + std::to_string(options.InputChannels) + "].");
  }
  const bool fits = options.ExtraFeatures == 0 ? input.Extra.size() == 0
                                               : input.Extra.cols() == options.ExtraFeatures &&
      (input.Extra.rows() == 1 || input.Extra.rows() == this->NumberOfVertices());
  if (!fits)
  {
    throw InvalidInput("PoissonNetEvaluator: the extra features are " + FormatSize(input.Extra) + "; expected " +
      (options.ExtraFeatures == 0 ? "none."
                                  : "1 or " + vertices + " rows of " + std::to_string(options.ExtraFeatures) + "."));
  }
  if (input.CoupledSignal.size() != 0 &&
    (input.CoupledSignal.rows() != this->NumberOfVertices() || input.CoupledSignal.cols() != 3))
  {
    throw InvalidInput("PoissonNetEvaluator: the coupled signal is " + FormatSize(input.CoupledSignal) +
      "; expected [" + vertices + ", 3].");
  }
  if (!input.Signal.allFinite() || !input.Extra.allFinite() || !input.CoupledSignal.allFinite())
  {
    throw InvalidInput("PoissonNetEvaluator: an input is not finite; expected finite numbers.");
  }
}

FeatureMatrix PoissonNetEvaluator::Internals::EmbedExtra(const FeatureMatrix& extra) const
{
  if (!this->Weights.ExtraIn)
  {
    return {};
  }
  FeatureMatrix hidden(extra.rows(), this->Width());
  FeatureMatrix embedded(extra.rows(), this->Width());
  const VertexStage rows(extra.rows(), this->Width());
  rows.Affine(*this->Weights.ExtraIn, extra.data(), extra.cols(), hidden.data(), this->Width());
  rows.Gelu(hidden.data());
  rows.Affine(*this->Weights.ExtraOut, hidden.data(), this->Width(), embedded.data(), this->Width());
  return embedded;
}

VertexFeatures PoissonNetEvaluator::Internals::Prepare(
  const ComplexMlpWeights& mlp, const FeatureMatrix& features, FeatureMatrix& hidden) const
{
  if (!mlp.Modulated)
  {
    return { features.data(), nullptr };
  }
  hidden.resize(features.rows(), this->Width());
  this->Points.Affine(mlp.ModulatorIn, features.data(), this->Width(), hidden.data(), this->Width());
  return { features.data(), hidden.data() };
}

SolverRows::Channels PoissonNetEvaluator::Internals::SolutionChannels(
  const BlockWeights& block, const SolverRows& rows) const
{
  if (!block.SolutionNorm)
  {
    return rows.WithoutMean();
  }
  // The norm removes a mean itself, so the removal of the mass-weighted one before makes no difference.
  return rows.Normalized(this->Model->Options.MassWeightedNorm, block.SolutionNorm->Weight, block.SolutionNorm->Bias);
}

/// Sums over the faces around to averages, their tanh, and the norm when there is one.
void PoissonNetEvaluator::Internals::FinishProducts(const BlockWeights& block, FeatureMatrix& products) const
{
  const ActivationKernels& kernels = BestActivationKernels();
  ParallelFor(products.rows(), 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      products.row(v) *= this->InverseArea[v];
      kernels.ScaledTanh(products.row(v).data(), block.ProductScale.data(), 1, this->Width());
    }
  });
  if (!block.ProductNorm)
  {
    return;
  }
  constexpr double epsilon = 1e-12;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(products.rows());
  double total = weights.sum();
  if (this->Model->Options.MassWeightedNorm)
  {
    weights = this->Operators.VertexMass.cast<double>();
    total = weights.sum() + epsilon;
  }
  for (Eigen::Index c = 0; c < products.cols(); ++c)
  {
    const Eigen::ArrayXd column = products.col(c).cast<double>();
    const Eigen::ArrayXd centered = column - (column * weights.array()).sum() / total;
    const double variance = (centered.square() * weights.array()).sum() / total;
    products.col(c) = (centered / std::sqrt(variance + epsilon) * static_cast<double>(block.ProductNorm->Weight[c]) +
      static_cast<double>(block.ProductNorm->Bias[c]))
                        .cast<float>();
  }
}

void PoissonNetEvaluator::Internals::RunBlock(const BlockWeights& block, const FeatureMatrix& extra,
  FeatureMatrix& features, FeatureMatrix& hidden, FeatureMatrix& products, SolverRows& rows,
  const Progress& progress) const
{
  const VertexFeatures prepared = this->Prepare(block.GradientMlp, features, hidden);
  if (block.Products)
  {
    products.setZero(features.rows(), this->Width());
  }
  this->Faces.Run(prepared, block.GradientMlp, block.Products ? &*block.Products : nullptr, rows, products.data(),
    SubProgress(progress, 0.0, 0.75));
  rows.Solve(SubProgress(progress, 0.75, 0.85));

  VertexStage::Inputs inputs;
  inputs.Solution = &rows;
  inputs.SolutionChannels = this->SolutionChannels(block, rows);
  inputs.Bias1 = block.Bias1;
  if (extra.rows() == 1)
  {
    // The same condition everywhere is a bias.
    using Map = Eigen::Map<const FeatureMatrix>;
    Eigen::Map<Eigen::RowVectorXf>(inputs.Bias1.data(), this->Width()) += extra.row(0) *
      Map(block.FromExtra.data(), this->Width(), this->Width());
  }
  else if (extra.rows() > 1)
  {
    inputs.Extra = extra.data();
  }
  if (block.Products)
  {
    this->FinishProducts(block, products);
    inputs.Products = products.data();
  }
  Report(progress, 0.9);
  this->Points.Run(block, inputs, features.data());
  Report(progress, 1.0);
}

PoissonNetPrediction PoissonNetEvaluator::Internals::LinearOutput(const FeatureMatrix& features) const
{
  const PoissonNetOptions& options = this->Model->Options;
  FeatureMatrix logits(features.rows(), options.OutputChannels);
  this->Points.Affine(this->Weights.LinearHead, features.data(), this->Width(), logits.data(), options.OutputChannels);
  PoissonNetPrediction prediction;
  prediction.Domain = options.Domain;
  if (options.Domain == PoissonNetDomain::Faces)
  {
    prediction.Values.resize(this->Operators.NumberOfTriangles(), options.OutputChannels);
    for (Index f = 0; f < this->Operators.NumberOfTriangles(); ++f)
    {
      const auto corners = this->Operators.Triangles.row(f);
      prediction.Values.row(f) = (logits.row(corners(0)) + logits.row(corners(1)) + logits.row(corners(2))) / 3.0F;
    }
  }
  else if (options.Domain == PoissonNetDomain::Global)
  {
    const Eigen::VectorXd mass = this->Operators.VertexMass.cast<double>();
    prediction.Values = (mass.transpose() * logits.cast<double>() / mass.sum()).cast<float>();
  }
  else
  {
    prediction.Values = std::move(logits);
  }
  if (options.Activation == LastActivation::LogSoftmax)
  {
    LogSoftmax(prediction.Values);
  }
  return prediction;
}

PoissonNetPrediction PoissonNetEvaluator::Internals::GradientOutput(const FeatureMatrix& features,
  FeatureMatrix& hidden, const FeatureMatrix& positions, const FeatureMatrix& coupled, const Progress& progress) const
{
  const VertexFeatures prepared = this->Prepare(*this->Weights.GradientHead, features, hidden);
  SolverRows rows = this->MakeRows(3);
  PoissonNetPrediction prediction;
  prediction.Gradients.resize(2 * static_cast<Eigen::Index>(this->Operators.NumberOfTriangles()), 3);
  this->Faces.RunHead(prepared, *this->Weights.GradientHead, positions.data(), rows, prediction.Gradients.data(),
    SubProgress(progress, 0.0, 0.9));
  if (this->Operators.Coupling)
  {
    rows.Add(*this->Operators.Coupling * coupled.cast<double>());
  }
  rows.Solve(SubProgress(progress, 0.9, 1.0));
  const SolverRows::Channels channels = rows.WithoutMean();
  prediction.Values.resize(features.rows(), 3);
  for (Index v = 0; v < this->Operators.NumberOfPoints(); ++v)
  {
    rows.Get(v, channels, prediction.Values.row(v).data());
  }
  return prediction;
}

PoissonNetEvaluator::PoissonNetEvaluator(std::shared_ptr<const PoissonNetModel> model, const TriangleMesh& mesh,
  const MeshTopology* topology, const Progress& progress, const ComponentCoupling& coupling)
{
  std::unique_ptr<MeshTopology> own;
  if (!topology)
  {
    own = std::make_unique<MeshTopology>(RequireValidMesh(mesh, Requirements(coupling.IsOn)));
    topology = own.get();
  }
  const MeshNormalization normalization = ComputeNormalization(mesh, model->Normalization);
  const TriangleMesh normalized = Normalized(mesh, normalization);
  std::vector<std::string> warnings = DescribeUnlikelyInput(mesh, *topology, model->Normalization);
  PoissonOperators operators = BuildPoissonOperators(
    normalized, *topology, progress, model->Options.Shift, ScaledCoupling(coupling, normalization));
  this->Impl = std::make_unique<Internals>(std::move(model), std::move(operators), normalized.Points);
  this->Impl->Normalization = normalization;
  this->Impl->Warnings = std::move(warnings);
}

PoissonNetEvaluator::PoissonNetEvaluator(
  std::shared_ptr<const PoissonNetModel> model, const PoissonOperators& operators, const PointMatrix& points)
{
  if (operators.Shift != model->Options.Shift)
  {
    throw InvalidInput(
      "PoissonNetEvaluator: the operators have another shift than the model; expected BuildPoissonOperators() with "
      "PoissonNetOptions::Shift.");
  }
  this->Impl = std::make_unique<Internals>(std::move(model), operators, points);
}

PoissonNetEvaluator::~PoissonNetEvaluator() = default;
PoissonNetEvaluator::PoissonNetEvaluator(PoissonNetEvaluator&&) noexcept = default;
PoissonNetEvaluator& PoissonNetEvaluator::operator=(PoissonNetEvaluator&&) noexcept = default;

PoissonNetPrediction PoissonNetEvaluator::Evaluate(const PoissonNetInput& input, const Progress& progress) const
{
  const Internals& self = *this->Impl;
  self.CheckInput(input);
  const SingleThreadedBlas blas;
  const FeatureMatrix& signal = input.Signal.size() == 0 ? self.Positions : input.Signal;
  const FeatureMatrix extra = self.EmbedExtra(input.Extra);
  FeatureMatrix features(self.NumberOfVertices(), self.Width());
  FeatureMatrix hidden;
  FeatureMatrix products;
  self.Points.Affine(self.Weights.ProjectIn, signal.data(), signal.cols(), features.data(), self.Width());

  const double steps = static_cast<double>(self.Weights.Blocks.size()) + (self.Weights.GradientHead ? 0.8 : 0.1);
  {
    SolverRows rows = self.MakeRows(self.Width());
    for (std::size_t k = 0; k < self.Weights.Blocks.size(); ++k)
    {
      const auto step = static_cast<double>(k);
      self.RunBlock(self.Weights.Blocks[k], extra, features, hidden, products, rows,
        SubProgress(progress, step / steps, (step + 1.0) / steps));
    }
  }
  const Progress last = SubProgress(progress, static_cast<double>(self.Weights.Blocks.size()) / steps, 1.0);
  const FeatureMatrix& coupled = input.CoupledSignal.size() == 0 ? signal : input.CoupledSignal;
  PoissonNetPrediction prediction = self.Weights.GradientHead
    ? self.GradientOutput(features, hidden, signal, coupled, last)
    : self.LinearOutput(features);
  if (!prediction.Values.allFinite() || !prediction.Gradients.allFinite())
  {
    throw NonFiniteOutput(
      "PoissonNetEvaluator: the network's output is not finite; expected a mesh and weights that single "
      "precision can hold.");
  }
  Report(progress, 1.0);
  return prediction;
}

MeshRequirements PoissonNetEvaluator::Requirements(bool coupled)
{
  MeshRequirements requirements;
  requirements.ConsistentWinding = true;
  requirements.SingleComponent = !coupled;
  return requirements;
}

const std::vector<std::string>& PoissonNetEvaluator::Warnings() const { return this->Impl->Warnings; }

const MeshNormalization& PoissonNetEvaluator::Normalization() const { return this->Impl->Normalization; }

const PoissonNetModel& PoissonNetEvaluator::Model() const { return *this->Impl->Model; }

const PoissonOperators& PoissonNetEvaluator::Operators() const { return this->Impl->Operators; }

std::vector<Index> PoissonNetPrediction::Labels() const
{
  std::vector<Index> labels(static_cast<std::size_t>(this->Values.rows()));
  for (Eigen::Index row = 0; row < this->Values.rows(); ++row)
  {
    Eigen::Index label = 0;
    this->Values.row(row).maxCoeff(&label);
    labels[row] = static_cast<Index>(label);
  }
  return labels;
}

PoissonNetPrediction EvaluatePoissonNet(
  const PoissonNetModel& model, const TriangleMesh& mesh, const PoissonNetInput& input, const Progress& progress)
{
  const auto shared = std::make_shared<const PoissonNetModel>(model);
  return PoissonNetEvaluator(shared, mesh, nullptr, SubProgress(progress, 0.0, 0.3))
    .Evaluate(input, SubProgress(progress, 0.3, 1.0));
}

} // namespace surfsynth
