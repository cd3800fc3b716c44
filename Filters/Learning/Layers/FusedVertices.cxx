// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/MatrixProduct.h"
#include "Inference/PoissonNet/GradientKernels.h"
#include "Learning/Layers/FusedFields.h"
#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Layers/FusedSteps.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Places of the weights behind the inputs of FusedVertexMlp().
enum VertexWeight
{
  VertexWeights = 0,
  VertexBiases = 4,
  VertexScales = 8,
  VertexWeightCount = 10
};

/// One tile of vertices through both halves of the MLP, and the way back.
class VertexTile
{
public:
  /// @param transposes of the maps
  VertexTile(const variable_list& inputs, const variable_list& weights, const variable_list& transposes)
    : Inputs(inputs)
    , Weights(weights)
    , Transposes(transposes)
    , Width(inputs[0].size(-1))
    , Kernels(BestGradientKernels())
    , Scratch(9 * StepTileRows * this->Width)
  {
    for (float*& array : this->Arrays)
    {
      array = this->Scratch.Take(StepTileRows * this->Width);
    }
  }

  /// Computes rows @p first and on; the result is Output().
  void Forward(std::int64_t first, std::int64_t rows)
  {
    const std::int64_t width = this->Width;
    this->Kernels.FillRows(this->Weight(VertexBiases), rows, width, this->Arrays[Hidden1]);
    for (std::size_t k = 0; k < this->Inputs.size(); ++k)
    {
      MultiplyInCache({ this->Row(k, first), width }, { this->FirstTransposed(k), width }, this->Arrays[Hidden1], width,
        rows, width, width, true);
    }
    this->Activate(Hidden1, rows, Active1);
    this->Affine(1, this->Arrays[Active1], rows, this->Arrays[Terms1]);
    std::copy_n(this->Row(0, first), rows * width, this->Arrays[Middle]);
    this->Kernels.AddScaled(this->Arrays[Terms1], this->Weight(VertexScales), rows, width, this->Arrays[Middle]);
    this->Affine(2, this->Arrays[Middle], rows, this->Arrays[Hidden2]);
    this->Activate(Hidden2, rows, Active2);
    this->Affine(3, this->Arrays[Active2], rows, this->Arrays[Terms2]);
  }

  /// Writes the result.
  void Write(std::int64_t rows, float* out) const
  {
    std::copy_n(this->Arrays[Middle], rows * this->Width, out);
    this->Kernels.AddScaled(this->Arrays[Terms2], this->Weight(VertexScales + 1), rows, this->Width, out);
  }

  /// Adds the derivatives by the weights to those of a part and sets those by the inputs, from those by the result.
  void Backward(std::int64_t first, std::int64_t rows, const float* gradient, const PartSums& sums, std::int64_t part,
    const std::vector<float*>& byInputs)
  {
    const std::int64_t width = this->Width;
    float* middle = this->Arrays[Derivative];
    std::copy_n(gradient, rows * width, middle);
    this->HalfBackward(2, gradient, rows, sums, part);
    MultiplyInCache(
      { this->Arrays[Other], width }, { this->Weight(2), width }, middle, width, rows, width, width, true);
    this->WeightGradient(2, this->Arrays[Middle], rows, sums, part);
    this->HalfBackward(0, middle, rows, sums, part);
    for (std::size_t k = 0; k < this->Inputs.size(); ++k)
    {
      const auto stride = static_cast<std::int64_t>(this->Inputs.size()) * width;
      MultiplyInCache({ this->Arrays[Other], width, true }, { this->Row(k, first), width },
        sums.Of(VertexWeights, part) + static_cast<std::int64_t>(k) * width, stride, width, rows, width, true);
      float* to = byInputs[k] + first * width;
      if (k == 0)
      {
        std::copy_n(middle, rows * width, to);
      }
      MultiplyInCache({ this->Arrays[Other], width }, this->FirstMap(k), to, width, rows, width, width, k == 0);
    }
    this->Kernels.AddColumnSums(this->Arrays[Other], rows, width, sums.Of(VertexBiases, part));
  }

private:
  enum Array
  {
    Hidden1, ///< hidden values, then slopes of their activation
    Active1,
    Terms1,
    Middle,
    Hidden2,
    Active2,
    Terms2,
    Derivative,
    Other,
    ArrayCount
  };

  const float* Weight(std::size_t k) const { return this->Weights[k].data_ptr<float>(); }
  const float* Row(std::size_t k, std::int64_t first) const
  {
    return this->Inputs[k].data_ptr<float>() + first * this->Width;
  }
  /// Columns of the first map that belong to input @p k.
  MatrixBlock FirstMap(std::size_t k) const
  {
    return { this->Weight(VertexWeights) + static_cast<std::int64_t>(k) * this->Width,
      static_cast<std::int64_t>(this->Inputs.size()) * this->Width };
  }
  /// Their transpose, [W, W].
  const float* FirstTransposed(std::size_t k) const
  {
    return this->Transposes[0].data_ptr<float>() + static_cast<std::int64_t>(k) * this->Width * this->Width;
  }
  void Affine(std::size_t k, const float* in, std::int64_t rows, float* out) const
  {
    this->Kernels.FillRows(this->Weight(VertexBiases + k), rows, this->Width, out);
    MultiplyInCache({ in, this->Width }, { this->Transposes[k].data_ptr<float>(), this->Width }, out, this->Width, rows,
      this->Width, this->Width, true);
  }
  /// Leaves the slopes in place of the hidden values.
  void Activate(Array hidden, std::int64_t rows, Array active)
  {
    float* const values = this->Arrays[hidden];
    this->Kernels.GeluWithSlopes(values, rows * this->Width, this->Arrays[active], values);
  }
  /// Adds derivatives by map and bias @p k from those by its result in Other.
  void WeightGradient(std::size_t k, const float* in, std::int64_t rows, const PartSums& sums, std::int64_t part)
  {
    MultiplyInCache({ this->Arrays[Other], this->Width, true }, { in, this->Width }, sums.Of(k, part), this->Width,
      this->Width, rows, this->Width, true);
    this->Kernels.AddColumnSums(this->Arrays[Other], rows, this->Width, sums.Of(VertexBiases + k, part));
  }
  /// From a half's result back to its hidden values: maps @p k and k + 1. Leaves the derivative by the hidden values in
  /// Other.
  void HalfBackward(std::size_t k, const float* gradient, std::int64_t rows, const PartSums& sums, std::int64_t part)
  {
    const std::int64_t width = this->Width;
    const std::size_t scale = VertexScales + k / 2;
    const Array terms = k == 0 ? Terms1 : Terms2;
    float* other = this->Arrays[Other];
    this->Kernels.AddScaledBackward(
      gradient, this->Arrays[terms], this->Weight(scale), rows, width, other, sums.Of(scale, part));
    this->WeightGradient(k + 1, this->Arrays[k == 0 ? Active1 : Active2], rows, sums, part);
    MultiplyInCache({ other, width }, { this->Weight(k + 1), width }, this->Arrays[terms], width, rows, width, width);
    this->Kernels.Scale(this->Arrays[k == 0 ? Hidden1 : Hidden2], rows * width, this->Arrays[terms]);
    std::swap(this->Arrays[terms], this->Arrays[Other]);
  }

  const variable_list& Inputs;
  const variable_list& Weights;
  const variable_list& Transposes;
  std::int64_t Width;
  const GradientKernels& Kernels;
  TileScratch Scratch;
  float* Arrays[ArrayCount];
};

/// Transposes of the maps among the weights.
variable_list MapTransposes(const variable_list& weights)
{
  variable_list transposes;
  std::transform(weights.begin() + VertexWeights, weights.begin() + VertexBiases, std::back_inserter(transposes),
    [](const torch::Tensor& map) { return map.t().contiguous(); });
  return transposes;
}

/// Calls body(part, first, rows) for tiles of rows.
template <typename Body>
void ForVertexTiles(std::int64_t rows, const Body& body)
{
  const std::int64_t tiles = (rows + StepTileRows - 1) / StepTileRows;
  ForStepTasks(tiles, [&](std::int64_t part, std::int64_t tile) {
    const std::int64_t first = rows * tile / tiles;
    body(part, first, rows * (tile + 1) / tiles - first);
  });
}

class VertexMlpStep : public torch::autograd::Function<VertexMlpStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const at::TensorList& inputs, const at::TensorList& weights)
  {
    variable_list in;
    const auto contiguous = [](const torch::Tensor& tensor) { return tensor.contiguous(); };
    std::transform(inputs.begin(), inputs.end(), std::back_inserter(in), contiguous);
    variable_list maps;
    std::transform(weights.begin(), weights.end(), std::back_inserter(maps), contiguous);
    const torch::Tensor out = torch::empty_like(in[0]);
    const std::int64_t width = out.size(-1);
    const variable_list transposes = MapTransposes(maps);
    ForVertexTiles(out.numel() / width, [&](std::int64_t, std::int64_t first, std::int64_t rows) {
      VertexTile tile(in, maps, transposes);
      tile.Forward(first, rows);
      tile.Write(rows, out.data_ptr<float>() + first * width);
    });
    context->saved_data["inputs"] = static_cast<std::int64_t>(in.size());
    in.insert(in.end(), maps.begin(), maps.end());
    context->save_for_backward(in);
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RequireFirstFieldDerivatives();
    const variable_list saved = context->get_saved_variables();
    const std::int64_t count = context->saved_data["inputs"].toInt();
    const variable_list in(saved.begin(), saved.begin() + count);
    const variable_list maps(saved.begin() + count, saved.end());
    const torch::Tensor gradient = gradients[0].contiguous();
    const std::int64_t width = gradient.size(-1);
    variable_list derivatives;
    std::vector<float*> byInputs;
    for (const torch::Tensor& input : in)
    {
      derivatives.push_back(torch::empty_like(input));
      byInputs.push_back(derivatives.back().data_ptr<float>());
    }
    const PartSums sums(maps);
    const variable_list transposes = MapTransposes(maps);
    ForVertexTiles(gradient.numel() / width, [&](std::int64_t part, std::int64_t first, std::int64_t rows) {
      VertexTile tile(in, maps, transposes);
      tile.Forward(first, rows);
      tile.Backward(first, rows, gradient.data_ptr<float>() + first * width, sums, part, byInputs);
    });
    for (std::size_t k = 0; k < maps.size(); ++k)
    {
      derivatives.push_back(sums.Total(k));
    }
    return derivatives;
  }
};
} // namespace

torch::Tensor FusedVertexMlp(const std::vector<torch::Tensor>& inputs, const VertexMlpWeights& weights)
{
  variable_list maps(std::begin(weights.Weight), std::end(weights.Weight));
  maps.insert(maps.end(), std::begin(weights.Bias), std::end(weights.Bias));
  maps.insert(maps.end(), std::begin(weights.Scale), std::end(weights.Scale));
  return VertexMlpStep::apply(at::TensorList(inputs), at::TensorList(maps));
}

} // namespace surfsynth
