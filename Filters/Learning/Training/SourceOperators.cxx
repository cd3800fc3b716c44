// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/SourceOperators.h"

#include "Learning/Layers/DensePoisson.h"
#include "Learning/Layers/FusedLayers.h"
#include "Learning/Layers/FusedPoisson.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace surfsynth
{

namespace
{
/// A dense inverse of more vertices than this takes more memory and time than it saves.
constexpr Index LargestDenseInverse = 10000;

std::uint64_t BytesOf(const torch::Tensor& tensor)
{
  return tensor.defined() ? static_cast<std::uint64_t>(tensor.nbytes()) : 0U;
}

template <typename Value>
std::uint64_t BytesOf(const std::vector<Value>& values)
{
  return values.size() * sizeof(Value);
}

/// Factor and matrix; the ids of the rows of supernodes, a few percent of it, are left out.
std::uint64_t BytesOf(const CholeskySolver& solver)
{
  const auto entries = static_cast<std::uint64_t>(solver.FactorEntries());
  const auto stored = static_cast<std::uint64_t>(solver.Matrix().nonZeros());
  const auto rows = static_cast<std::uint64_t>(solver.Size());
  return entries * sizeof(double) + stored * (sizeof(double) + sizeof(Index)) +
    rows * (sizeof(double) + 3 * sizeof(Index));
}

std::uint64_t BytesOf(const FaceIncidence& tables)
{
  std::uint64_t bytes = tables.Corners.size() * sizeof(Index) + BytesOf(tables.Offsets) + BytesOf(tables.Faces);
  bytes += (tables.BasisGradients.size() + tables.Areas.size()) * sizeof(float);
  for (const FaceIncidence::Weights* weights : { &tables.Transposed, &tables.Divergence })
  {
    for (const std::vector<float>& values : *weights)
    {
      bytes += BytesOf(values);
    }
  }
  return bytes;
}

std::uint64_t BytesOf(const PoissonTables& tables)
{
  const FacePatches& patches = tables.Patches;
  return BytesOf(patches.FaceStart) + BytesOf(patches.FaceOfPlace) + BytesOf(patches.Corners) +
    BytesOf(patches.LocalCorners) + BytesOf(patches.BasisGradients) + BytesOf(patches.Areas) +
    BytesOf(patches.VertexStart) + BytesOf(patches.Vertices) + BytesOf(patches.Slot) + BytesOf(patches.SharedVertices) +
    BytesOf(patches.SlotStart) + tables.Mass.size() * sizeof(double);
}

std::uint64_t BytesOf(const MeshTensors& mesh)
{
  std::uint64_t bytes = BytesOf(mesh.FaceAreas) + BytesOf(mesh.VertexMass) + BytesOf(mesh.InverseArea) +
    BytesOf(mesh.Used) + BytesOf(mesh.DenseInverse) + BytesOf(*mesh.Solver);
  for (int k = 0; k < 3; ++k)
  {
    bytes += BytesOf(mesh.Corners[k]) + BytesOf(mesh.BasisGradientX[k]) + BytesOf(mesh.BasisGradientY[k]);
  }
  bytes += mesh.Incidence ? BytesOf(*mesh.Incidence) : 0U;
  return bytes + (mesh.Tables ? BytesOf(*mesh.Tables) : 0U);
}

/// Bytes of a noise on @p mesh. Its matrices have the entries of the Poisson equation's, and thus its factor's.
std::uint64_t BytesOfNoise(const FlowNoise& noise, const TriangleMesh& mesh, const CholeskySolver& poisson)
{
  const bool solves = noise.Model == NoiseModel::Matern || noise.Model == NoiseModel::Unscreened;
  const auto vertices = static_cast<std::uint64_t>(mesh.NumberOfPoints());
  constexpr std::uint64_t arrays = 6; // masses, amplitudes, and ids of components and rows
  std::uint64_t bytes = static_cast<std::uint64_t>(mesh.Points.size()) * sizeof(double) +
    static_cast<std::uint64_t>(mesh.Triangles.size()) * sizeof(Index) + arrays * vertices * sizeof(double);
  bytes += ((solves ? 1U : 0U) + (noise.Smoothing > 0.0 ? 1U : 0U)) * BytesOf(poisson);
  const std::uint64_t pairs = noise.Model == NoiseModel::Spectral ? static_cast<std::uint64_t>(noise.Eigenpairs) : 0U;
  return bytes + pairs * vertices * sizeof(double);
}
} // namespace

SourceOperators::SourceOperators(const TriangleMesh& mesh, SourceFactors factors, const torch::Device& device)
  : Mesh(factors.Operators, torch::TensorOptions(torch::kFloat32).device(device),
      mesh.Points.cast<float>().cast<double>()) // as the network sees them
  , Noise(std::move(factors.Noise))
{
  if (device.is_cuda() && mesh.NumberOfPoints() <= LargestDenseInverse)
  {
    UseDenseInverse(this->Mesh);
  }
  this->Bytes = BytesOf(this->Mesh) + BytesOfNoise(factors.NoiseOptions, mesh, *this->Mesh.Solver);
}

SourceCache::SourceCache(double limit, Builder build)
  : Limit(limit)
  , Build(std::move(build))
{}

void SourceCache::Offer(std::size_t source, SourceOperators operators)
{
  this->Sizes[source] = operators.Bytes;
  if (static_cast<double>(this->Used.Bytes + operators.Bytes) <= this->Limit)
  {
    this->Insert(source, std::move(operators));
  }
}

const SourceOperators& SourceCache::Get(std::size_t source)
{
  const auto kept = this->EntryOf.find(source);
  if (kept != this->EntryOf.end())
  {
    this->Entries.splice(this->Entries.begin(), this->Entries, kept->second);
    return kept->second->Operators;
  }
  const auto size = this->Sizes.find(source);
  this->MakeRoom(size != this->Sizes.end() ? size->second : 0U);
  const auto begin = std::chrono::steady_clock::now();
  SourceOperators operators = this->Build(source);
  this->Used.BuildSeconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ++this->Used.Builds;
  this->MakeRoom(operators.Bytes);
  this->Insert(source, std::move(operators));
  return this->Entries.front().Operators;
}

/// Drops what was not used for longest until @p bytes fit, or nothing is left.
void SourceCache::MakeRoom(std::uint64_t bytes)
{
  while (!this->Entries.empty() && static_cast<double>(this->Used.Bytes + bytes) > this->Limit)
  {
    this->Used.Bytes -= this->Entries.back().Operators.Bytes;
    this->EntryOf.erase(this->Entries.back().Source);
    this->Entries.pop_back();
  }
}

void SourceCache::Insert(std::size_t source, SourceOperators operators)
{
  this->Used.Bytes += operators.Bytes;
  this->Used.Peak = std::max(this->Used.Peak, this->Used.Bytes);
  this->Sizes[source] = operators.Bytes;
  this->Entries.push_front({ source, std::move(operators) });
  this->EntryOf[source] = this->Entries.begin();
}

} // namespace surfsynth
