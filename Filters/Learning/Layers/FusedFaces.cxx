// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/MatrixProduct.h"
#include "Inference/PoissonNet/GradientKernels.h"
#include "Learning/Layers/FusedFields.h"
#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Layers/FusedSteps.h"
#include "Learning/Layers/KeptValue.h"

#include <algorithm>
#include <functional>

// Longer than other files: both steps share the tile and the way back.

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

torch::Tensor LikeWith(const torch::Tensor& like, std::int64_t rows, std::int64_t channels)
{
  std::vector<std::int64_t> shape = like.sizes().vec();
  shape[shape.size() - 2] = rows;
  shape.back() = channels;
  return torch::empty(shape, like.options());
}

/// Inputs of a step on faces.
enum FaceInput
{
  FaceX,
  FaceHidden,
  FaceModulator,
  FaceModulatorBias,
  FaceLayers,
  FaceBiases,
  FaceTail, ///< map for dot products, or last map
  FaceInputs
};

/// Transposes of the maps, which products on the way back read; absent ones are empty or undefined.
struct FaceTransposes
{
  torch::Tensor Modulator;
  torch::Tensor Layers;
  torch::Tensor Tail;
};

/// One tile of faces: their features, and the way back.
class FaceTile
{
public:
  /// @param transposes for Backward(), or null; with them Forward() keeps the slopes of activations
  FaceTile(const PoissonTables& tables, const variable_list& in, const FaceTransposes* transposes = nullptr)
    : Patches(tables.Patches)
    , Width(in[FaceX].size(-1))
    , Layers(in[FaceLayers].size(0))
    , Weights{ DataOf(in[FaceModulator]), DataOf(in[FaceModulatorBias]), DataOf(in[FaceLayers]),
      DataOf(in[FaceBiases]) }
    , Transposes{ transposes ? DataOf(transposes->Modulator) : nullptr, nullptr,
      transposes ? DataOf(transposes->Layers) : nullptr, nullptr }
    , Kernels(BestGradientKernels())
    , KeepsSlopes(transposes != nullptr)
    , Scratch(StepTileRows * this->Width * (2 * (2 * this->Layers + 6) + 3 + 3 * this->Layers))
  {
    const std::int64_t complexRows = 2 * StepTileRows * this->Width;
    this->Gradient = this->Scratch.Take(complexRows);
    this->PhaseAndScale = this->Scratch.Take(complexRows);
    for (std::int64_t k = 0; k <= this->Layers; ++k)
    {
      this->States.push_back(k == 0 && !this->Weights.Modulator ? this->Gradient : this->Scratch.Take(complexRows));
    }
    for (std::int64_t k = 0; k < this->Layers; ++k)
    {
      this->Products.push_back(this->Scratch.Take(complexRows));
      this->Slopes.push_back(this->Scratch.Take(3 * StepTileRows * this->Width));
    }
    this->ModulationSlopes = this->Scratch.Take(StepTileRows * this->Width);
    this->Derivative = this->Scratch.Take(complexRows);
    this->Other = this->Scratch.Take(complexRows);
    this->Third = this->Scratch.Take(complexRows);
    this->Mean = this->Scratch.Take(StepTileRows * this->Width);
    this->Activated = this->Scratch.Take(StepTileRows * this->Width);
  }

  /// Gradients of faces @p first and on of the patches' order through all layers. @param x, hidden of one signal
  void Forward(const float* x, const float* hidden, std::int64_t first, std::int64_t rows)
  {
    this->First = first;
    this->Rows = rows;
    const std::int64_t width = this->Width;
    const FaceRows faces = this->Of(this->Patches.Corners);
    this->Kernels.Gradient(x, faces, width, this->Gradient);
    if (this->Weights.Modulator)
    {
      this->Kernels.CornerMean(hidden, faces, width, this->Mean);
      this->ModulateGradient();
    }
    for (std::int64_t k = 0; k < this->Layers; ++k)
    {
      float* const product = this->Products[k];
      const float* const bias = this->Weights.Biases + k * width;
      MultiplyInCache({ this->States[k], 2 * width }, { this->LayerOf(this->Weights, k), 2 * width }, product,
        2 * width, rows, 2 * width, 2 * width);
      if (this->KeepsSlopes)
      {
        this->Kernels.ComplexGeluWithSlopes(product, bias, rows, width, this->States[k + 1], this->Slopes[k]);
      }
      else
      {
        this->Kernels.ComplexGelu(product, bias, rows, width, this->States[k + 1]);
      }
    }
  }

  /// Features of the last layer, complex rows.
  const float* Features() const { return this->States.back(); }
  /// Gradients of x, complex rows.
  const float* Gradients() const { return this->Gradient; }
  /// Faces of the tile with the corners of the mesh or of the patch.
  FaceRows Of(const std::vector<Index>& corners) const
  {
    return { corners.data() + 3 * this->First, this->Patches.BasisGradients.data() + 6 * this->First,
      this->Patches.Areas.data() + this->First, this->Rows };
  }
  /// Places for complex rows: the derivatives by the features, which Backward() takes, and two others.
  float* ByFeatures() const { return this->Derivative; }
  float* Spare() const { return this->Other; }
  float* SecondSpare() const { return this->Third; }

  /// Adds the derivatives by the weights to those of a part, and those by x and hidden to @p sums, [points of the patch, W or
  /// 2 W]. @param byGradients complex rows that are added to the derivatives by the gradients, or null
  void Backward(const PartSums& weights, std::int64_t part, const float* byGradients, float* sums)
  {
    const std::int64_t width = this->Width;
    const std::int64_t rows = this->Rows;
    float* derivative = this->Derivative;
    float* next = this->Other;
    for (std::int64_t k = this->Layers - 1; k >= 0; --k)
    {
      this->Kernels.ComplexGeluBackward(
        this->Products[k], this->Slopes[k], rows, width, derivative, weights.Of(FaceBiases, part) + k * width);
      MultiplyInCache({ this->States[k], 2 * width, true }, { derivative, 2 * width },
        weights.Of(FaceLayers, part) + 4 * k * width * width, 2 * width, 2 * width, rows, 2 * width, true);
      MultiplyInCache({ derivative, 2 * width }, { this->LayerOf(this->Transposes, k), 2 * width }, next, 2 * width,
        rows, 2 * width, 2 * width);
      std::swap(derivative, next);
    }
    const float* byMean = nullptr;
    if (this->Weights.Modulator)
    {
      byMean = this->ModulationBackward(weights, part, derivative);
    }
    if (byGradients)
    {
      std::transform(derivative, derivative + 2 * rows * width, byGradients, derivative, std::plus<float>());
    }
    this->Kernels.AddTransposed(derivative, byMean, this->Of(this->Patches.LocalCorners), width, sums);
  }

private:
  struct Matrices
  {
    const float* Modulator;
    const float* ModulatorBias;
    const float* Layers;
    const float* Biases;
  };

  const float* LayerOf(const Matrices& matrices, std::int64_t k) const
  {
    return matrices.Layers + 4 * k * this->Width * this->Width;
  }

  /// Sets the first state to the gradients times the factors of the corners' mean, in whose place the slopes of its activation
  /// are left if they are kept.
  void ModulateGradient()
  {
    const std::int64_t width = this->Width;
    const std::int64_t rows = this->Rows;
    if (this->KeepsSlopes)
    {
      this->Kernels.GeluWithSlopes(this->Mean, rows * width, this->Activated, this->Mean);
    }
    else
    {
      this->Kernels.Gelu(this->Mean, rows * width, this->Activated);
    }
    this->Kernels.FillRows(this->Weights.ModulatorBias, rows, 2 * width, this->PhaseAndScale);
    MultiplyInCache({ this->Activated, width }, { this->Weights.Modulator, 2 * width }, this->PhaseAndScale, 2 * width,
      rows, width, 2 * width, true);
    if (this->KeepsSlopes)
    {
      this->Kernels.ModulateWithSlopes(
        this->PhaseAndScale, this->Gradient, rows, width, this->States[0], this->ModulationSlopes);
    }
    else
    {
      this->Kernels.Modulate(this->PhaseAndScale, this->Gradient, rows, width, this->States[0]);
    }
  }

  /// Replaces the derivative by the modulated gradients by that by the gradients; returns that by the corners' mean.
  const float* ModulationBackward(const PartSums& weights, std::int64_t part, float* derivative)
  {
    const std::int64_t width = this->Width;
    const std::int64_t rows = this->Rows;
    this->Kernels.ModulateBackward(
      this->States[0], this->ModulationSlopes, rows, width, this->PhaseAndScale, derivative);
    this->Kernels.AddColumnSums(this->PhaseAndScale, rows, 2 * width, weights.Of(FaceModulatorBias, part));
    MultiplyInCache({ this->Activated, width, true }, { this->PhaseAndScale, 2 * width },
      weights.Of(FaceModulator, part), 2 * width, width, rows, 2 * width, true);
    MultiplyInCache({ this->PhaseAndScale, 2 * width }, { this->Transposes.Modulator, width }, this->Activated, width,
      rows, 2 * width, width);
    this->Kernels.Scale(this->Mean, rows * width, this->Activated);
    return this->Activated;
  }

  const FacePatches& Patches;
  std::int64_t Width;
  std::int64_t Layers;
  Matrices Weights;
  Matrices Transposes;
  const GradientKernels& Kernels;
  bool KeepsSlopes;
  TileScratch Scratch;
  float* Gradient;
  float* PhaseAndScale;
  std::vector<float*> States;
  std::vector<float*> Products;
  std::vector<float*> Slopes; ///< of the activations of each layer, [rows, 3 W]
  float* ModulationSlopes;
  float* Derivative;
  float* Other;
  float* Third;
  float* Mean;
  float* Activated;
  std::int64_t First = 0;
  std::int64_t Rows = 0;
};

/// Calls body(first, rows) for the tiles of a patch.
template <typename Body>
void ForTilesOfPatch(const FacePatches& patches, std::int64_t p, const Body& body)
{
  ForStepTiles(
    patches.Faces(p), [&](std::int64_t first, std::int64_t rows) { body(patches.FaceStart[p] + first, rows); });
}

/// Sums over the faces around the vertices of a batch of signals, which come from patches.
class VertexSums
{
public:
  VertexSums(const PoissonTables& tables, std::int64_t batch, std::int64_t width)
    : Tables(tables)
    , Width(width)
    , Slots(static_cast<std::size_t>(batch * tables.Patches.Slots() * width))
  {}

  /// Passes the sums of patch @p p of signal @p b on to write(vertex, row), or keeps them.
  template <typename Write>
  void Distribute(std::int64_t b, std::int64_t p, const float* sums, const Write& write)
  {
    DistributeSums(this->Tables.Patches, p, sums, this->Width, this->SlotsOf(b), write);
  }
  /// Passes the sums of the vertices of several patches on.
  template <typename Write>
  void Combine(std::int64_t b, const Write& write)
  {
    CombineSlots(this->Tables.Patches, this->SlotsOf(b), this->Width, write);
  }

private:
  float* SlotsOf(std::int64_t b) { return this->Slots.data() + b * this->Tables.Patches.Slots() * this->Width; }

  const PoissonTables& Tables;
  std::int64_t Width;
  LargeArray<float> Slots;
};

/// Largest number of vertices of a patch.
std::int64_t PointsOfPatches(const FacePatches& patches)
{
  std::int64_t points = 0;
  for (std::int64_t p = 0; p < patches.Count(); ++p)
  {
    points = std::max(points, patches.Points(p));
  }
  return points;
}

/// Transposes of the weights of a step on faces.
FaceTransposes TransposesOf(const variable_list& in)
{
  const auto transpose = [](const torch::Tensor& tensor) {
    return IsPresent(tensor) ? tensor.transpose(-2, -1).contiguous() : torch::Tensor();
  };
  return { transpose(in[FaceModulator]), transpose(in[FaceLayers]), transpose(in[FaceTail]) };
}

/// Backward pass of both steps on faces. @param derive sets the derivatives by the features of a tile, from the transpose of
/// the last map, and returns those by the gradients that come on another way, or null
template <typename Derive>
variable_list FaceDerivatives(const PoissonTables& tables, const variable_list& in, const Derive& derive)
{
  const FacePatches& patches = tables.Patches;
  const std::int64_t width = in[FaceX].size(-1);
  const std::int64_t batch = BatchOf(in[FaceX]);
  const bool modulated = IsPresent(in[FaceModulator]);
  const std::int64_t stride = modulated ? 2 * width : width;
  const std::int64_t points = PointsOfPatches(patches);
  const torch::Tensor byX = torch::zeros_like(in[FaceX]);
  const torch::Tensor byHidden = modulated ? torch::zeros_like(in[FaceHidden]) : torch::Tensor();
  VertexSums gathered(tables, batch, stride);
  const auto writeTo = [&](std::int64_t b) {
    float* const x = byX.data_ptr<float>() + b * byX.size(-2) * width;
    float* const hidden = modulated ? byHidden.data_ptr<float>() + b * byX.size(-2) * width : nullptr;
    return [=](Index vertex, const float* row) {
      std::copy_n(row, width, x + vertex * width);
      if (hidden)
      {
        std::copy_n(row + width, width, hidden + vertex * width);
      }
    };
  };
  const PartSums weights(
    { {}, {}, in[FaceModulator], in[FaceModulatorBias], in[FaceLayers], in[FaceBiases], in[FaceTail] });
  const FaceTransposes transposes = TransposesOf(in);
  const float* const tail = DataOf(transposes.Tail);
  ForStepTasks(batch * patches.Count(), [&](std::int64_t part, std::int64_t task) {
    const std::int64_t b = task / patches.Count();
    const std::int64_t p = task % patches.Count();
    FaceTile tile(tables, in, &transposes);
    TileScratch scratch(points * stride);
    float* sums = scratch.Take(patches.Points(p) * stride);
    std::fill_n(sums, patches.Points(p) * stride, 0.0F);
    ForTilesOfPatch(patches, p, [&](std::int64_t first, std::int64_t rows) {
      tile.Forward(SignalOf(in[FaceX], b), SignalOf(in[FaceHidden], b), first, rows);
      tile.Backward(weights, part, derive(tile, b, first, rows, tail, weights.Of(FaceTail, part)), sums);
    });
    gathered.Distribute(b, p, sums, writeTo(b));
  });
  for (std::int64_t b = 0; b < batch; ++b)
  {
    gathered.Combine(b, writeTo(b));
  }
  variable_list derivatives = { byX, byHidden };
  for (std::size_t k = FaceModulator; k < FaceInputs; ++k)
  {
    derivatives.push_back(weights.Total(k));
  }
  return derivatives;
}

/// Features of faces, added up at the vertices.
class FeatureSumsStep : public torch::autograd::Function<FeatureSumsStep>
{
public:
  static variable_list forward(AutogradContext* context, const std::shared_ptr<const PoissonTables>& tables,
    const torch::Tensor& x, const torch::Tensor& hidden, const torch::Tensor& modulator,
    const torch::Tensor& modulatorBias, const torch::Tensor& layers, const torch::Tensor& biases,
    const torch::Tensor& productMap)
  {
    const variable_list in = { x.contiguous(), hidden.contiguous(), modulator.contiguous(), modulatorBias,
      layers.contiguous(), biases.contiguous(), productMap.contiguous() };
    context->save_for_backward(in);
    KeepValue(context, tables);
    const std::int64_t width = x.size(-1);
    const bool dots = IsPresent(productMap);
    const torch::Tensor divergence = LikeWith(in[FaceX], tables->NumberOfVertices(), 2 * width).zero_();
    const torch::Tensor products = dots ? torch::zeros_like(in[FaceX]) : torch::Tensor();
    Sum(*tables, in, divergence, products);
    return dots ? variable_list{ divergence, products } : variable_list{ divergence };
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const variable_list in = context->get_saved_variables();
    const auto tables = KeptValue<std::shared_ptr<const PoissonTables>>(context);
    const torch::Tensor byDivergence = gradients[0].contiguous();
    const torch::Tensor byDots = gradients.size() > 1 ? gradients[1].contiguous() : torch::Tensor();
    const std::int64_t width = in[FaceX].size(-1);
    const GradientKernels& kernels = BestGradientKernels();
    variable_list derivatives = FaceDerivatives(*tables, in,
      [&](FaceTile& tile, std::int64_t b, std::int64_t, std::int64_t rows, const float* transposed,
        float* byMap) -> const float* {
        const FaceRows faces = tile.Of(tables->Patches.Corners);
        kernels.DivergenceTransposed(SignalOf(byDivergence, b), faces, width, tile.ByFeatures());
        return byDots.defined() ? DotsBackward(tile, in, SignalOf(byDots, b), faces, rows, transposed, byMap) : nullptr;
      });
    derivatives.insert(derivatives.begin(), torch::Tensor()); // of the tables
    return derivatives;
  }

private:
  static void Sum(const PoissonTables& tables, const variable_list& in, const torch::Tensor& divergence,
    const torch::Tensor& products)
  {
    const FacePatches& patches = tables.Patches;
    const std::int64_t width = in[FaceX].size(-1);
    const std::int64_t batch = BatchOf(in[FaceX]);
    const std::int64_t stride = (products.defined() ? 3 : 2) * width;
    const std::int64_t points = PointsOfPatches(patches);
    VertexSums complexSums(tables, batch, 2 * width);
    VertexSums dotSums(tables, products.defined() ? batch : 0, width);
    const auto writeTo = [](const torch::Tensor& tensor, std::int64_t b) {
      const std::int64_t channels = tensor.size(-1);
      float* const to = tensor.data_ptr<float>() + b * tensor.size(-2) * channels;
      return [to, channels](Index vertex, const float* row) { std::copy_n(row, channels, to + vertex * channels); };
    };
    const GradientKernels& kernels = BestGradientKernels();
    ForStepTasks(batch * patches.Count(), [&](std::int64_t, std::int64_t task) {
      const std::int64_t b = task / patches.Count();
      const std::int64_t p = task % patches.Count();
      FaceTile tile(tables, in);
      TileScratch scratch(points * stride);
      float* sums = scratch.Take(patches.Points(p) * 2 * width);
      float* dots = scratch.Take(products.defined() ? patches.Points(p) * width : 0);
      std::fill_n(sums, patches.Points(p) * stride, 0.0F);
      ForTilesOfPatch(patches, p, [&](std::int64_t first, std::int64_t rows) {
        tile.Forward(SignalOf(in[FaceX], b), SignalOf(in[FaceHidden], b), first, rows);
        const FaceRows faces = tile.Of(patches.LocalCorners);
        kernels.AddDivergence(tile.Features(), faces, width, sums);
        if (products.defined())
        {
          MultiplyInCache({ tile.Features(), 2 * width }, { in[FaceTail].data_ptr<float>(), 2 * width }, tile.Spare(),
            2 * width, rows, 2 * width, 2 * width);
          kernels.AddDots(tile.Spare(), tile.Gradients(), faces, width, dots);
        }
      });
      complexSums.Distribute(b, p, sums, writeTo(divergence, b));
      if (products.defined())
      {
        dotSums.Distribute(b, p, dots, writeTo(products, b));
      }
    });
    for (std::int64_t b = 0; b < batch; ++b)
    {
      complexSums.Combine(b, writeTo(divergence, b));
      if (products.defined())
      {
        dotSums.Combine(b, writeTo(products, b));
      }
    }
  }

  /// Derivatives of dot products: adds those by the features and the map, returns those by the gradients.
  static const float* DotsBackward(FaceTile& tile, const variable_list& in, const float* byDots, const FaceRows& faces,
    std::int64_t rows, const float* transposed, float* byMap)
  {
    const std::int64_t width = in[FaceX].size(-1);
    const float* map = in[FaceTail].data_ptr<float>();
    float* mapped = tile.Spare();
    float* byGradients = tile.SecondSpare();
    MultiplyInCache({ tile.Features(), 2 * width }, { map, 2 * width }, mapped, 2 * width, rows, 2 * width, 2 * width);
    std::fill_n(byGradients, 2 * rows * width, 0.0F);
    BestGradientKernels().DotsBackward(byDots, tile.Gradients(), faces, width, mapped, byGradients);
    MultiplyInCache(
      { tile.Features(), 2 * width, true }, { mapped, 2 * width }, byMap, 2 * width, 2 * width, rows, 2 * width, true);
    MultiplyInCache(
      { mapped, 2 * width }, { transposed, 2 * width }, tile.ByFeatures(), 2 * width, rows, 2 * width, 2 * width, true);
    return byGradients;
  }
};

/// Features of faces through one more map.
class FaceFeaturesStep : public torch::autograd::Function<FaceFeaturesStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const std::shared_ptr<const PoissonTables>& tables,
    const torch::Tensor& x, const torch::Tensor& hidden, const torch::Tensor& modulator,
    const torch::Tensor& modulatorBias, const torch::Tensor& layers, const torch::Tensor& biases,
    const torch::Tensor& last)
  {
    const variable_list in = { x.contiguous(), hidden.contiguous(), modulator.contiguous(), modulatorBias,
      layers.contiguous(), biases.contiguous(), last.contiguous() };
    context->save_for_backward(in);
    KeepValue(context, tables);
    const FacePatches& patches = tables->Patches;
    const std::int64_t width = x.size(-1);
    const std::int64_t channels = last.size(1);
    const torch::Tensor out = LikeWith(in[FaceX], tables->NumberOfFaces(), channels);
    ForStepTasks(BatchOf(in[FaceX]) * patches.Count(), [&](std::int64_t, std::int64_t task) {
      const std::int64_t b = task / patches.Count();
      FaceTile tile(*tables, in);
      float* to = out.data_ptr<float>() + b * out.size(-2) * channels;
      TileScratch scratch(StepTileRows * channels);
      float* mapped = scratch.Take(StepTileRows * channels);
      ForTilesOfPatch(patches, task % patches.Count(), [&](std::int64_t first, std::int64_t rows) {
        tile.Forward(SignalOf(in[FaceX], b), SignalOf(in[FaceHidden], b), first, rows);
        Multiply(tile.Features(), in[FaceTail].data_ptr<float>(), mapped, rows, 2 * width, channels);
        for (std::int64_t row = 0; row < rows; ++row)
        {
          std::copy_n(mapped + row * channels, channels, to + patches.FaceOfPlace[first + row] * channels);
        }
      });
    });
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const variable_list in = context->get_saved_variables();
    const auto tables = KeptValue<std::shared_ptr<const PoissonTables>>(context);
    const torch::Tensor gradient = gradients[0].contiguous();
    const std::int64_t width = in[FaceX].size(-1);
    const std::int64_t channels = gradient.size(-1);
    variable_list derivatives = FaceDerivatives(*tables, in,
      [&](FaceTile& tile, std::int64_t b, std::int64_t first, std::int64_t rows, const float* transposed,
        float* byLast) -> const float* {
        const float* from = SignalOf(gradient, b);
        TileScratch scratch(rows * channels);
        float* byMapped = scratch.Take(rows * channels);
        for (std::int64_t row = 0; row < rows; ++row)
        {
          std::copy_n(from + tables->Patches.FaceOfPlace[first + row] * channels, channels, byMapped + row * channels);
        }
        MultiplyInCache({ tile.Features(), 2 * width, true }, { byMapped, channels }, byLast, channels, 2 * width, rows,
          channels, true);
        MultiplyInCache(
          { byMapped, channels }, { transposed, 2 * width }, tile.ByFeatures(), 2 * width, rows, channels, 2 * width);
        return nullptr;
      });
    derivatives.insert(derivatives.begin(), torch::Tensor()); // of the tables
    return derivatives;
  }
};
} // namespace

FeatureSums FusedFeatureSums(const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& x,
  const torch::Tensor& hidden, const ComplexMatrices& mlp, const torch::Tensor& productMap)
{
  const variable_list sums = FeatureSumsStep::apply(tables, x, OrEmpty(hidden), OrEmpty(mlp.Modulator),
    OrEmpty(mlp.ModulatorBias), mlp.Layers, mlp.Biases, OrEmpty(productMap));
  return { sums[0], sums.size() > 1 ? sums[1] : torch::Tensor() };
}

torch::Tensor FusedFaceFeatures(const std::shared_ptr<const PoissonTables>& tables, const torch::Tensor& x,
  const torch::Tensor& hidden, const ComplexMatrices& mlp, const torch::Tensor& last)
{
  return FaceFeaturesStep::apply(
    tables, x, OrEmpty(hidden), OrEmpty(mlp.Modulator), OrEmpty(mlp.ModulatorBias), mlp.Layers, mlp.Biases, last);
}

} // namespace surfsynth
