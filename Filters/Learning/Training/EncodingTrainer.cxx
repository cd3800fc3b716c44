// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/EncodingTrainer.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/EdgeSplits.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Random/CounterUniforms.h"
#include "Core/Solvers/LaplaceEigenpairs.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"
#include "Learning/Layers/EdgeFeatureTensors.h"
#include "Learning/Networks/InitialWeights.h"
#include "Learning/Training/NetworkTraining.h"
#include "Learning/Training/OptionChecks.h"
#include "Learning/Training/TrainingSources.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
PoissonNetOptions EncoderOptions(const EncodingTrainingOptions& options)
{
  PoissonNetOptions network = NetworkOfSize(options);
  network.OutputChannels = options.Eigenfunctions;
  network.Head = PoissonNetHead::Linear;
  return network;
}

void RequireCorrespondence(const SignalDataset& dataset)
{
  CheckDataset(dataset);
  const TriangleMesh& reference = dataset.Sources.front().Mesh;
  for (std::size_t k = 1; k < dataset.Sources.size(); ++k)
  {
    const TriangleMesh& mesh = dataset.Sources[k].Mesh;
    const bool sameSize = mesh.NumberOfPoints() == reference.NumberOfPoints() &&
      mesh.NumberOfTriangles() == reference.NumberOfTriangles();
    if (!sameSize || mesh.Triangles != reference.Triangles)
    {
      throw InvalidInput("EncodingTrainer: source " + std::to_string(k) + " has " +
        (sameSize ? "other triangles than source 0"
                  : std::to_string(mesh.NumberOfPoints()) + " vertices and " +
              std::to_string(mesh.NumberOfTriangles()) + " triangles, and source 0 has " +
              std::to_string(reference.NumberOfPoints()) + " and " + std::to_string(reference.NumberOfTriangles())) +
        "; expected surfaces whose vertices correspond, with the same triangles in the same order.");
    }
  }
}

/// Checks the meshes of all sources. @returns the topology of the first, the reference.
MeshTopology RequireValidSources(const SignalDataset& dataset, const Progress& progress)
{
  std::optional<MeshTopology> reference;
  for (std::size_t k = 0; k < dataset.Sources.size(); ++k)
  {
    try
    {
      MeshTopology topology = RequireValidMesh(dataset.Sources[k].Mesh, FlowMatchingSampler::Requirements());
      if (k == 0)
      {
        reference = std::move(topology);
      }
    }
    catch (const InvalidInput& error)
    {
      throw InvalidInput("Source " + std::to_string(k) + " of the dataset: " + error.what());
    }
    Report(progress, static_cast<double>(k + 1) / static_cast<double>(dataset.Sources.size()));
  }
  return std::move(*reference);
}

TriangleMesh UnitArea(const TriangleMesh& mesh) { return Normalized(mesh, FlowNormalization(mesh)); }

/// Eigenfunctions 1 to @p count of the Laplacian of @p mesh with mean square 1, [V, count].
FeatureMatrix Eigenfunctions(const TriangleMesh& mesh, const MeshTopology& topology, std::int64_t count)
{
  if (count + 2 > mesh.NumberOfPoints())
  {
    throw InvalidInput("EncodingTrainer: " + std::to_string(count) + " eigenfunctions on " +
      std::to_string(mesh.NumberOfPoints()) + " vertices; expected more vertices.");
  }
  const Eigenpairs pairs = LowestLaplaceEigenpairs(
    CotangentStiffness(mesh, topology), LumpedMass(mesh, topology), static_cast<Index>(count + 1));
  // Normalised over the surface already, whose area is 1.
  return pairs.Vectors.rightCols(count).cast<float>();
}
} // namespace

void CheckOptions(const EncodingTrainingOptions& options)
{
  CheckOptions(static_cast<const TrainingOptions&>(options));
  const OptionChecks check("TrainingOptions");
  check.Count("Eigenfunctions", options.Eigenfunctions, 1, 10000);
  check.Count("BatchSize", options.BatchSize, 1, 100000);
  if (!(options.EdgeSplits >= 0.0) || !(options.EdgeSplits <= 1.0))
  {
    throw InvalidInput("TrainingOptions: EdgeSplits is " + FormatNumber(options.EdgeSplits) + "; expected 0 to 1.");
  }
}

class EncodingTrainer::Internals
{
public:
  Internals(SignalDataset dataset, const EncodingTrainingOptions& options, const Progress& progress)
    : Options(options)
    , Dataset(std::move(dataset))
    , DatasetHash(ContentHash(this->Dataset))
    , Training(InitialPoissonNet(EncoderOptions(options), options.Seed), options)
  {
    RequireCorrespondence(this->Dataset);
    const MeshTopology topology = RequireValidSources(this->Dataset, SubProgress(progress, 0.0, 0.1));
    const TriangleMesh& reference = this->Dataset.Sources.front().Mesh;
    this->Target = ToTensor(
      Eigenfunctions(UnitArea(reference), topology, options.Eigenfunctions), this->Training.Device());
    Report(progress, 1.0);
  }

  void Accumulate(const std::vector<SubdividedMesh>& surfaces, NetworkLosses& losses);
  std::vector<SubdividedMesh> Surfaces() const;
  std::map<std::string, std::string> Recipe() const;

  EncodingTrainingOptions Options;
  SignalDataset Dataset;
  std::uint64_t DatasetHash;
  NetworkTraining Training;

private:
  TriangleMesh Surface(std::int64_t slot) const;
  SubdividedMesh Split(TriangleMesh mesh, std::int64_t slot) const;
  torch::Tensor TargetOn(const SubdividedMesh& surface) const;

  torch::Tensor Target; ///< [V, Eigenfunctions]
};

/// A source or one of its samples, each equally likely within its source. @throws InvalidInput when it is degenerate.
TriangleMesh EncodingTrainer::Internals::Surface(std::int64_t slot) const
{
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Sample = static_cast<std::uint32_t>(this->Training.Iteration());
  key.Component = static_cast<std::uint32_t>(slot);
  const auto number = static_cast<std::size_t>(
    UniformIndex(key, 0, static_cast<std::int64_t>(this->Dataset.Sources.size())));
  const SignalSource& source = this->Dataset.Sources[number];
  const std::int64_t samples = this->Dataset.HoldsPositions() ? source.NumberOfSamples() : 0;
  const std::int64_t sample = UniformIndex(key, 1, samples + 1);
  TriangleMesh mesh = source.Mesh;
  if (sample > 0)
  {
    const float* positions = source.Samples.row(sample - 1).data();
    std::copy(positions, positions + mesh.Points.size(), mesh.Points.data());
  }
  try
  {
    mesh = UnitArea(mesh);
    RequireValidMesh(mesh, FlowMatchingSampler::Requirements());
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput("EncodingTrainer: sample " + std::to_string(sample - 1) + " of source " +
      std::to_string(number) + " is no surface to learn from: " + error.what());
  }
  return mesh;
}

/// Another triangulation of @p mesh, or the same without EdgeSplits.
SubdividedMesh EncodingTrainer::Internals::Split(TriangleMesh mesh, std::int64_t slot) const
{
  if (this->Options.EdgeSplits == 0.0)
  {
    return { std::move(mesh), {} };
  }
  NormalKey key;
  key.Seed = this->Options.Seed;
  key.Stream = 1; // 0 draws the surfaces
  key.Sample = static_cast<std::uint32_t>(this->Training.Iteration());
  key.Component = static_cast<std::uint32_t>(slot);
  const double share = Uniform(key, 0) * this->Options.EdgeSplits;
  return SplitEdges(mesh, [&](std::int64_t edge) { return Uniform(key, edge + 1) < share; });
}

/// The surfaces of this iteration.
std::vector<SubdividedMesh> EncodingTrainer::Internals::Surfaces() const
{
  std::vector<SubdividedMesh> surfaces;
  for (std::int64_t slot = 0; slot < this->Options.BatchSize; ++slot)
  {
    surfaces.push_back(this->Split(this->Surface(slot), slot));
  }
  return surfaces;
}

/// The eigenfunctions at the vertices of a surface, [V + E, Eigenfunctions].
torch::Tensor EncodingTrainer::Internals::TargetOn(const SubdividedMesh& surface) const
{
  if (surface.Parents.empty())
  {
    return this->Target;
  }
  const torch::Tensor parents = ParentTensor(surface, this->Training.Device());
  return torch::cat({ this->Target, TakeRows(this->Target, parents).mean(1) }, 0);
}

/// The loss of this iteration and its gradient, which is added to that of the parameters.
void EncodingTrainer::Internals::Accumulate(const std::vector<SubdividedMesh>& surfaces, NetworkLosses& losses)
{
  const torch::Device device = this->Training.Device();
  for (const SubdividedMesh& split : surfaces)
  {
    const TriangleMesh& surface = split.Mesh;
    const MeshTensors mesh(
      BuildPoissonOperators(surface, MeshTopology(surface), {}, this->Training.Network().Options().Shift),
      torch::TensorOptions(torch::kFloat32).device(device), surface.Points);
    const torch::Tensor positions = ToTensor(surface.Points.cast<float>(), device);
    const torch::Tensor difference = this->Training.Network().forward(mesh, positions).Values - this->TargetOn(split);
    const torch::Tensor loss = MassMean(mesh, difference.square()).mean() / static_cast<double>(surfaces.size());
    loss.backward();
    losses.Vertex += loss.item<double>();
  }
  losses.Total = losses.Vertex;
}

std::map<std::string, std::string> EncodingTrainer::Internals::Recipe() const
{
  std::map<std::string, std::string> recipe = RecipeOf(this->Options, "encoding");
  recipe["eigenfunctions"] = std::to_string(this->Options.Eigenfunctions);
  recipe["batch_size"] = std::to_string(this->Options.BatchSize);
  if (this->Options.EdgeSplits != 0.0) // checkpoints of trainings that could have no other have no entry
  {
    recipe["edge_splits"] = FormatExact(this->Options.EdgeSplits);
  }
  recipe["dataset"] = std::to_string(this->DatasetHash);
  return recipe;
}

EncodingTrainer::EncodingTrainer(
  SignalDataset dataset, const EncodingTrainingOptions& options, const Progress& progress)
{
  CheckOptions(options);
  this->Impl = std::make_unique<Internals>(std::move(dataset), options, progress);
}

EncodingTrainer::~EncodingTrainer() = default;
EncodingTrainer::EncodingTrainer(EncodingTrainer&&) noexcept = default;
EncodingTrainer& EncodingTrainer::operator=(EncodingTrainer&&) noexcept = default;

void EncodingTrainer::Step()
{
  const std::vector<SubdividedMesh> surfaces = this->Impl->Surfaces();
  this->Impl->Training.Step([&](NetworkLosses& losses) { this->Impl->Accumulate(surfaces, losses); });
}

std::int64_t EncodingTrainer::Iterations() const { return this->Impl->Options.Iterations; }

const LossHistory& EncodingTrainer::History() const { return this->Impl->Training.History(); }

std::string EncodingTrainer::DeviceName() const { return NameOf(this->Impl->Training.Device()); }

std::map<std::string, std::string> EncodingTrainer::Recipe() const { return this->Impl->Recipe(); }

TrainingCheckpoint EncodingTrainer::Checkpoint() const { return this->Impl->Training.Checkpoint(); }

void EncodingTrainer::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  this->Impl->Training.Restore(file, checkpoint);
}

void EncodingTrainer::SaveModel(const std::string& path) const { WritePoissonNet(path, this->Model()); }

PoissonNetModel EncodingTrainer::Model() const
{
  PoissonNetModel model = this->Impl->Training.Model();
  model.Normalization = InputNormalization::SurfaceArea;
  return model;
}

EncodingTrainer TrainEncoding(SignalDataset dataset, const EncodingTrainingOptions& options, const TrainingFiles& files,
  const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  EncodingTrainer trainer(std::move(dataset), options, SubProgress(progress, 0.0, 0.02));
  TrainAndSave(trainer, files, observe, SubProgress(progress, 0.02, 1.0));
  return trainer;
}

} // namespace surfsynth
