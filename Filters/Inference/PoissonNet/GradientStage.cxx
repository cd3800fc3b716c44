// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/GradientStage.h"

#include "Core/Common/Parallel.h"
#include "Inference/Common/MatrixProduct.h"

#include <algorithm>
#include <atomic>

namespace surfsynth
{

namespace
{
/// Counts patches that are done, for reports by the calling thread.
class Counter
{
public:
  Counter(std::int64_t count, const Progress& progress)
    : Count(count)
    , OnProgress(progress)
  {}
  void Step() { ++this->Done; }
  void ReportDone() const
  {
    Report(this->OnProgress, static_cast<double>(this->Done.load()) / static_cast<double>(this->Count));
  }

private:
  std::int64_t Count;
  const Progress& OnProgress;
  std::atomic<std::int64_t> Done{ 0 };
};
} // namespace

GradientStage::GradientStage(std::shared_ptr<const FacePatches> patches, std::int64_t width)
  : Patches(std::move(patches))
  , Width(width)
  , Kernels(BestActivationKernels())
{
  for (std::int64_t p = 0; p < this->Patches->Count(); ++p)
  {
    this->MaximumNumberOfPoints = std::max(this->MaximumNumberOfPoints, this->Patches->Points(p));
  }
}

GradientStage::Scratch GradientStage::Borrow() const
{
  Scratch scratch = this->Pool.Borrow();
  if (scratch.Tiles.size() == 0)
  {
    scratch.Tiles = LargeArray<float>(static_cast<std::size_t>(8 * TileRows * this->Width));
    scratch.Sums = LargeArray<float>(
      static_cast<std::size_t>(4 * this->MaximumNumberOfPoints * std::max<std::int64_t>(this->Width, 3)));
  }
  return scratch;
}

GradientStage::Tile GradientStage::Divide(const Scratch& scratch) const
{
  float* base = const_cast<float*>(scratch.Tiles.data());
  const auto array = [&](int k) { return base + k * TileRows * this->Width; };
  return { array(0), array(1), array(2), { array(3), array(4), array(5) }, array(6), array(7) };
}

/// Gradients of a tile of faces through the modulation and all layers but the last, in tile.Re, tile.Im and tile.Sum.
void GradientStage::Features(std::int64_t first, std::int64_t rows, const VertexFeatures& features,
  const ComplexMlpWeights& mlp, bool keepPlain, const Tile& tile) const
{
  const FacePatches& patches = *this->Patches;
  const std::int64_t width = this->Width;
  const Index* corners = patches.Corners.data() + 3 * first;
  this->Kernels.FaceGradient(
    features.Values, corners, patches.BasisGradients.data() + 6 * first, rows, width, tile.Re, tile.Im);
  if (keepPlain)
  {
    std::copy_n(tile.Re, rows * width, tile.PlainRe);
    std::copy_n(tile.Im, rows * width, tile.PlainIm);
  }
  if (mlp.Modulated)
  {
    this->Kernels.FaceMeanGelu(features.ModulatorHidden, corners, rows, width, tile.Products[2]);
    Multiply(tile.Products[2], mlp.ModulatorOut.Matrix.data(), tile.Products[0], rows, width, 2 * width);
    this->Kernels.Modulate(tile.Products[0], mlp.ModulatorOut.Bias.data(), rows, width, tile.Re, tile.Im, tile.Sum);
  }
  else
  {
    std::transform(tile.Re, tile.Re + rows * width, tile.Im, tile.Sum, [](float re, float im) { return re + im; });
  }
  for (const ComplexLayerWeights& layer : mlp.Layers)
  {
    this->ThreeProducts(layer.Product, rows, tile);
    this->Kernels.ComplexGelu(tile.Products[0], tile.Products[1], tile.Products[2], layer.MagnitudeBias.data(), rows,
      width, tile.Re, tile.Im, tile.Sum);
  }
}

void GradientStage::ThreeProducts(const ComplexWeights& weights, std::int64_t rows, const Tile& tile) const
{
  const std::int64_t width = this->Width;
  Multiply(tile.Sum, weights.A.data(), tile.Products[0], rows, width, width);
  Multiply(tile.Re, weights.B.data(), tile.Products[1], rows, width, width);
  Multiply(tile.Im, weights.C.data(), tile.Products[2], rows, width, width);
}

void GradientStage::RunPatch(std::int64_t p, const VertexFeatures& features, const ComplexMlpWeights& mlp,
  const ComplexWeights* productMap, SolverRows& target, float* products, float* slots, float* productSlots) const
{
  const FacePatches& patches = *this->Patches;
  const std::int64_t width = this->Width;
  const std::int64_t size = patches.Points(p) * width;
  Scratch scratch = this->Borrow();
  const Tile tile = this->Divide(scratch);
  float* along = scratch.Sums.data();
  float* across = along + size;
  float* result = across + size;
  float* dots = result + size;
  std::fill_n(along, 2 * size, 0.0F);
  std::fill_n(dots, productMap ? size : 0, 0.0F);
  for (std::int64_t first = patches.FaceStart[p]; first < patches.FaceStart[p + 1]; first += TileRows)
  {
    const std::int64_t rows = std::min(TileRows, patches.FaceStart[p + 1] - first);
    const Index* corners = patches.LocalCorners.data() + 3 * first;
    const float* areas = patches.Areas.data() + first;
    this->Features(first, rows, features, mlp, productMap != nullptr, tile);
    this->Kernels.ScatterDivergence(
      tile.Re, tile.Im, corners, patches.BasisGradients.data() + 6 * first, areas, rows, width, along, across);
    if (productMap)
    {
      this->ThreeProducts(*productMap, rows, tile);
      this->Kernels.ScatterDots(tile.Products[0], tile.Products[1], tile.Products[2], tile.PlainRe, tile.PlainIm,
        corners, areas, rows, width, dots);
    }
  }
  // The last layer is complex-linear: it turns the two sums into the divergence of its output, at a quarter of the
  // cost.
  Multiply(along, mlp.LastReal.data(), result, patches.Points(p), width, width);
  Multiply(across, mlp.LastImaginary.data(), result, patches.Points(p), width, width, true);
  DistributeSums(patches, p, result, width, slots, [&](Index vertex, const float* row) { target.Set(vertex, row); });
  if (productMap)
  {
    DistributeSums(patches, p, dots, width, productSlots,
      [&](Index vertex, const float* row) { std::copy_n(row, width, products + vertex * width); });
  }
  this->Pool.Return(std::move(scratch));
}

void GradientStage::Run(const VertexFeatures& features, const ComplexMlpWeights& mlp, const ComplexWeights* productMap,
  SolverRows& target, float* products, const Progress& progress) const
{
  const std::int64_t width = this->Width;
  LargeArray<float> slots(static_cast<std::size_t>(this->Patches->Slots() * width));
  LargeArray<float> productSlots(productMap ? slots.size() : 0);
  Counter counter(this->Patches->Count(), progress);
  ParallelTasks(
    this->Patches->Count(),
    [&](std::int64_t p) {
      this->RunPatch(p, features, mlp, productMap, target, products, slots.data(), productSlots.data());
      counter.Step();
    },
    [&] { counter.ReportDone(); });
  CombineSlots(*this->Patches, slots.data(), width, [&](Index vertex, const float* row) { target.Set(vertex, row); });
  if (productMap)
  {
    CombineSlots(*this->Patches, productSlots.data(), width,
      [&](Index vertex, const float* row) { std::copy_n(row, width, products + vertex * width); });
  }
}

void GradientStage::RunHeadPatch(std::int64_t p, const VertexFeatures& features, const ComplexMlpWeights& mlp,
  const float* positions, SolverRows& target, float* gradients, float* slots) const
{
  const FacePatches& patches = *this->Patches;
  Scratch scratch = this->Borrow();
  const Tile tile = this->Divide(scratch);
  float* sums = scratch.Sums.data();
  std::fill_n(sums, 3 * patches.Points(p), 0.0F);
  std::vector<float> own(static_cast<std::size_t>(2 * TileRows * 3));
  std::vector<float> maps(static_cast<std::size_t>(4 * TileRows * 3));
  float* const ownRe = own.data();
  float* const ownIm = ownRe + TileRows * 3;
  float* const map[4] = { maps.data(), maps.data() + TileRows * 3, maps.data() + 2 * TileRows * 3,
    maps.data() + 3 * TileRows * 3 };
  for (std::int64_t first = patches.FaceStart[p]; first < patches.FaceStart[p + 1]; first += TileRows)
  {
    const std::int64_t rows = std::min(TileRows, patches.FaceStart[p + 1] - first);
    this->Features(first, rows, features, mlp, false, tile);
    Multiply(tile.Re, mlp.LastReal.data(), map[0], rows, this->Width, 3);
    Multiply(tile.Im, mlp.LastImaginary.data(), map[1], rows, this->Width, 3);
    Multiply(tile.Re, mlp.LastImaginary.data(), map[2], rows, this->Width, 3);
    Multiply(tile.Im, mlp.LastReal.data(), map[3], rows, this->Width, 3);
    this->Kernels.FaceGradient(
      positions, patches.Corners.data() + 3 * first, patches.BasisGradients.data() + 6 * first, rows, 3, ownRe, ownIm);
    for (std::int64_t row = 0; row < rows; ++row)
    {
      const float area = patches.Areas[first + row];
      const float* basisGradients = patches.BasisGradients.data() + 6 * (first + row);
      float* out = gradients + 6 * static_cast<std::int64_t>(patches.FaceOfPlace[first + row]);
      for (int c = 0; c < 3; ++c)
      {
        out[c] = ownRe[3 * row + c] + (map[0][3 * row + c] - map[1][3 * row + c]);
        out[3 + c] = ownIm[3 * row + c] + (map[2][3 * row + c] + map[3][3 * row + c]);
        for (int corner = 0; corner < 3; ++corner)
        {
          sums[3 * patches.LocalCorners[3 * (first + row) + corner] + c] += area *
            (basisGradients[corner] * out[c] + basisGradients[3 + corner] * out[3 + c]);
        }
      }
    }
  }
  DistributeSums(patches, p, sums, 3, slots, [&](Index vertex, const float* row) { target.Set(vertex, row); });
  this->Pool.Return(std::move(scratch));
}

void GradientStage::RunHead(const VertexFeatures& features, const ComplexMlpWeights& mlp, const float* positions,
  SolverRows& target, float* gradients, const Progress& progress) const
{
  LargeArray<float> slots(static_cast<std::size_t>(this->Patches->Slots() * 3));
  Counter counter(this->Patches->Count(), progress);
  ParallelTasks(
    this->Patches->Count(),
    [&](std::int64_t p) {
      this->RunHeadPatch(p, features, mlp, positions, target, gradients, slots.data());
      counter.Step();
    },
    [&] { counter.ReportDone(); });
  CombineSlots(*this->Patches, slots.data(), 3, [&](Index vertex, const float* row) { target.Set(vertex, row); });
}

} // namespace surfsynth
