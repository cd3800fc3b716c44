// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FaceSelection.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Inference/GeometricTexture/FaceKernels.h"
#include "Inference/GeometricTexture/FaceStepKernels.h"
#include "Learning/Layers/KeptValue.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

/// Triangles of a task. Sums over all triangles are those of tasks, added in order.
constexpr std::int64_t FacesAtOnce = 256;

using SelectionPointer = std::shared_ptr<const FaceSelection>;

/// Calls body(task, first, count) for ranges of @p rows rows on torch's threads.
void ForRanges(std::int64_t rows, const std::function<void(std::int64_t, std::int64_t, std::int64_t)>& body)
{
  const ThreadScope threads(at::get_num_threads());
  ParallelTasks((rows + FacesAtOnce - 1) / FacesAtOnce, [&](std::int64_t task) {
    const std::int64_t first = task * FacesAtOnce;
    body(task, first, std::min(FacesAtOnce, rows - first));
  });
}

/// Sums of columns over tasks, [tasks, parts, width].
class TaskSums
{
public:
  TaskSums(std::int64_t rows, std::int64_t parts, std::int64_t width)
    : Rows(rows)
    , Size(parts * width)
    , Values(static_cast<std::size_t>((rows + FacesAtOnce - 1) / FacesAtOnce * parts * width), 0.0)
  {}
  double* Of(std::int64_t task) { return this->Values.data() + task * this->Size; }

  /// Means over all rows, [parts, width].
  std::vector<double> Means() const
  {
    std::vector<double> means(static_cast<std::size_t>(this->Size), 0.0);
    for (std::size_t k = 0; k < this->Values.size(); ++k)
    {
      means[k % means.size()] += this->Values[k];
    }
    for (double& mean : means)
    {
      mean /= static_cast<double>(this->Rows);
    }
    return means;
  }

private:
  std::int64_t Rows;
  std::int64_t Size;
  std::vector<double> Values;
};

torch::Tensor FloatTensor(const std::vector<double>& values)
{
  const torch::Tensor tensor = torch::empty({ static_cast<std::int64_t>(values.size()) }, torch::kFloat32);
  std::transform(
    values.begin(), values.end(), tensor.data_ptr<float>(), [](double x) { return static_cast<float>(x); });
  return tensor;
}

/// Products [*, C'] or [*, 2 C'] of triangles with @p width channels: what is given to neighbors, and to itself.
struct ProductHalves
{
  ProductHalves(const torch::Tensor& products, std::int64_t width)
    : Given{ products.data_ptr<float>(), products.size(1) }
    , Own{ products.size(1) == width ? nullptr : products.data_ptr<float>() + width, products.size(1) }
  {}
  StridedRows Given;
  StridedRows Own;
};

/// Largest products of all triangles, their places, and the scale of their norm.
struct SelectedProducts
{
  torch::Tensor Values; ///< [F, C']
  torch::Tensor Places; ///< [F, C'] uint8
  torch::Tensor Scale;  ///< [C'], undefined without norm
};

SelectedProducts SelectProducts(const FaceProducts& in, bool normalize)
{
  const torch::Tensor products = in.Products.contiguous();
  const torch::Tensor bias = in.Bias.contiguous();
  const std::int64_t width = bias.numel();
  const std::int64_t faces = in.Selection->NumberOfFaces();
  const ProductHalves halves(products, width);
  SelectedProducts out;
  out.Values = torch::empty({ faces, width }, products.options());
  out.Places = torch::empty({ faces, width }, torch::kUInt8);
  float* const values = out.Values.data_ptr<float>();
  std::uint8_t* const places = out.Places.data_ptr<std::uint8_t>();
  TaskSums sums(faces, 2, width);
  const float* const offset = bias.data_ptr<float>();
  ForRanges(faces, [&](std::int64_t task, std::int64_t first, std::int64_t count) {
    const std::int64_t at = first * width;
    BestFaceStepKernels().Largest(
      { in.Selection->Rows.data(), first, count, width }, halves.Given, halves.Own, offset, values + at, places + at);
    if (normalize)
    {
      BestFaceKernels().AddMoments(values + at, width, count, width, sums.Of(task), sums.Of(task) + width);
    }
  });
  if (!normalize)
  {
    return out;
  }
  constexpr double epsilon = 1e-5;
  std::vector<double> mean = sums.Means();
  std::vector<double> scale;
  for (std::int64_t c = 0; c < width; ++c)
  {
    const double center = mean[static_cast<std::size_t>(c)];
    const double variance = mean[static_cast<std::size_t>(width + c)] - center * center;
    scale.push_back(1.0 / std::sqrt(std::max(variance, 0.0) + epsilon));
  }
  out.Scale = FloatTensor(scale);
  const torch::Tensor centers = FloatTensor(mean);
  ForRanges(faces, [&](std::int64_t, std::int64_t first, std::int64_t count) {
    float* const rows = values + first * width;
    BestFaceKernels().Normalize(
      rows, width, centers.data_ptr<float>(), out.Scale.data_ptr<float>(), count, width, rows);
  });
  return out;
}

/// Numbers of rows and columns of products.
using ProductShape = std::array<std::int64_t, 2>;

/// Completes the transpose of the selection: derivatives by products, of which the halves of triangles themselves are there.
/// @param byValues derivatives by the selected values
void SumSelected(
  const FaceSelection& selection, const torch::Tensor& places, const StridedRows& byValues, torch::Tensor& byProducts)
{
  const std::int64_t width = places.size(1);
  const std::int64_t stride = byProducts.size(1);
  float* const out = byProducts.data_ptr<float>();
  ForRanges(byProducts.size(0), [&](std::int64_t, std::int64_t first, std::int64_t count) {
    BestFaceStepKernels().SumAtPlaces(
      { selection.Faces.data(), selection.Places.data(), selection.Uses, first, count, width },
      places.data_ptr<std::uint8_t>(), byValues, out + first * stride, stride);
  });
}

/// A tensor for derivatives by products, and where those by the selected values are written: into the halves of
/// triangles themselves, or apart.
struct ProductDerivatives
{
  ProductDerivatives(const ProductShape& shape, std::int64_t faces, std::int64_t width)
    : ByProducts(torch::empty({ shape[0], shape[1] }, torch::kFloat32))
    , Apart(shape[1] == width ? torch::empty({ faces, width }, torch::kFloat32) : torch::Tensor())
    , Stride(shape[1])
    , ByValues(Apart.defined() ? Apart.data_ptr<float>() : ByProducts.data_ptr<float>() + width)
  {}
  torch::Tensor ByProducts;
  torch::Tensor Apart;
  std::int64_t Stride; ///< of ByValues
  float* ByValues;
};

/// Saved tensors of the pass back.
enum SavedTensor
{
  SavedGradients,
  SavedActivated,
  SavedPlaces,
  SavedScale,
  SavedMeans ///< of h and h n, [2 C']
};

/// Derivatives by the products, itself differentiable: arguments are the derivatives by the results, the products, of which
/// only the place in the graph and the shape are used, and what SelectProducts() has found. Scale is empty without norm.
class SelectionGradientStep : public torch::autograd::Function<SelectionGradientStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& gradients, const torch::Tensor& products,
    const torch::Tensor& activated, const torch::Tensor& places, const torch::Tensor& scale,
    const SelectionPointer& selection)
  {
    KeepValue(context, selection);
    const torch::Tensor g = gradients.contiguous();
    const std::int64_t faces = g.size(0);
    const std::int64_t width = g.size(1);
    ProductDerivatives out({ products.size(0), products.size(1) }, faces, width);
    torch::Tensor means;
    if (scale.numel() == 0)
    {
      out.Apart.defined() ? out.Apart.copy_(g) : out.ByProducts.narrow(1, width, width).copy_(g);
    }
    else
    {
      means = MeansOf(g, activated);
      NormMeans norm{};
      norm.Scale = scale.data_ptr<float>();
      norm.Gradient = means.data_ptr<float>();
      norm.GradientTimes = norm.Gradient + width;
      ForRanges(faces, [&](std::int64_t, std::int64_t first, std::int64_t count) {
        BestFaceStepKernels().NormGradient(g.data_ptr<float>() + first * width,
          activated.data_ptr<float>() + first * width, norm, count, width, out.ByValues + first * out.Stride,
          out.Stride);
      });
    }
    SumSelected(*selection, places, { out.ByValues, out.Stride }, out.ByProducts);
    context->save_for_backward({ g, activated, places, scale, means.defined() ? means : torch::empty({ 0 }) });
    return out.ByProducts;
  }

  static variable_list backward(AutogradContext* context, const variable_list& directions)
  {
    if (torch::GradMode::is_enabled())
    {
      throw InvalidInput("FaceSelection: third derivatives of float32 convolutions on the processor are asked for; "
                         "expected first or second ones (float64 has all).");
    }
    const variable_list saved = context->get_saved_variables();
    const SelectionPointer selection = KeptValue<SelectionPointer>(context);
    const torch::Tensor products = directions[0].contiguous();
    const std::int64_t faces = saved[SavedGradients].size(0);
    const std::int64_t width = saved[SavedGradients].size(1);
    const ProductHalves halves(products, width);
    const torch::Tensor u = torch::empty({ faces, width }, torch::kFloat32);
    ForRanges(faces, [&](std::int64_t, std::int64_t first, std::int64_t count) {
      const std::int64_t at = first * width;
      BestFaceStepKernels().AtPlaces({ selection->Rows.data(), first, count, width }, halves.Given, halves.Own,
        saved[SavedPlaces].data_ptr<std::uint8_t>() + at, u.data_ptr<float>() + at);
    });
    if (saved[SavedScale].numel() == 0)
    {
      return { u, {}, {}, {}, {}, {} };
    }
    return NormDerivatives(*selection, saved, u, { products.size(0), products.size(1) });
  }

private:
  /// Means of h and h n over all triangles, [2 C'].
  static torch::Tensor MeansOf(const torch::Tensor& gradients, const torch::Tensor& activated)
  {
    const std::int64_t width = gradients.size(1);
    TaskSums sums(gradients.size(0), 2, width);
    ForRanges(gradients.size(0), [&](std::int64_t task, std::int64_t first, std::int64_t count) {
      BestFaceStepKernels().AddGradientSums(gradients.data_ptr<float>() + first * width,
        activated.data_ptr<float>() + first * width, count, width, sums.Of(task));
    });
    return FloatTensor(sums.Means());
  }

  static variable_list NormDerivatives(
    const FaceSelection& selection, const variable_list& saved, const torch::Tensor& u, const ProductShape& shape)
  {
    const std::int64_t faces = u.size(0);
    const std::int64_t width = u.size(1);
    const float* const directions = u.data_ptr<float>();
    const float* const gradients = saved[SavedGradients].data_ptr<float>();
    const float* const activated = saved[SavedActivated].data_ptr<float>();
    TaskSums sums(faces, 3, width);
    ForRanges(faces, [&](std::int64_t task, std::int64_t first, std::int64_t count) {
      const std::int64_t at = first * width;
      BestFaceStepKernels().AddDirectionSums(
        directions + at, gradients + at, activated + at, count, width, sums.Of(task));
    });
    const torch::Tensor ofDirections = FloatTensor(sums.Means());
    const float* const second = ofDirections.data_ptr<float>();
    const float* const first = saved[SavedMeans].data_ptr<float>();
    const NormMeans means{ saved[SavedScale].data_ptr<float>(), first, first + width, second, second + width,
      second + 2 * width };
    ProductDerivatives out(shape, faces, width);
    const torch::Tensor byGradients = torch::empty_like(u);
    ForRanges(faces, [&](std::int64_t, std::int64_t begin, std::int64_t count) {
      const std::int64_t at = begin * width;
      BestFaceStepKernels().NormSecondGradient(directions + at, gradients + at, activated + at, means, count, width,
        byGradients.data_ptr<float>() + at, out.ByValues + begin * out.Stride, out.Stride);
    });
    SumSelected(selection, saved[SavedPlaces], { out.ByValues, out.Stride }, out.ByProducts);
    return { byGradients, out.ByProducts, {}, {}, {}, {} };
  }
};

/// A selection with or without norm and activation.
class SelectionStep : public torch::autograd::Function<SelectionStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& products, const torch::Tensor& bias,
    const SelectionPointer& selection, bool normalize)
  {
    KeepValue(context, selection);
    const SelectedProducts out = SelectProducts({ products, bias, selection }, normalize);
    context->save_for_backward({ products, out.Values, out.Places, normalize ? out.Scale : torch::empty({ 0 }), bias });
    return out.Values;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    const variable_list saved = context->get_saved_variables();
    const torch::Tensor& scale = saved[3];
    const torch::Tensor byProducts = SelectionGradientStep::apply(
      gradients[0], saved[0], saved[1].detach(), saved[2], scale, KeptValue<SelectionPointer>(context));
    const torch::Tensor byBias = scale.numel() > 0 ? torch::zeros_like(saved[4]) : gradients[0].sum(0);
    return { byProducts, byBias, {}, {} };
  }
};
} // namespace

FaceSelection SelectNeighbors(const TriangleMatrix& neighbors)
{
  FaceSelection selection;
  selection.Uses = 3;
  selection.Rows.assign(neighbors.data(), neighbors.data() + neighbors.size());
  selection.Faces.resize(selection.Rows.size());
  selection.Places.resize(selection.Rows.size());
  // A triangle is seen across each of its edges once, by its neighbor or, at the boundary, by itself.
  std::vector<std::int64_t> found(static_cast<std::size_t>(neighbors.rows()), 0);
  for (std::size_t k = 0; k < selection.Rows.size(); ++k)
  {
    const auto row = static_cast<std::size_t>(selection.Rows[k]);
    const std::size_t entry = 3 * row + static_cast<std::size_t>(found[row]++);
    selection.Faces[entry] = static_cast<std::int32_t>(k / 3);
    selection.Places[entry] = static_cast<std::uint8_t>(k % 3);
  }
  return selection;
}

FaceSelection SelectEdges(std::int64_t faces)
{
  FaceSelection selection;
  selection.Uses = 1;
  for (std::int64_t row = 0; row < 3 * faces; ++row)
  {
    selection.Rows.push_back(static_cast<std::int32_t>(row));
    selection.Faces.push_back(static_cast<std::int32_t>(row / 3));
    selection.Places.push_back(static_cast<std::uint8_t>(row % 3));
  }
  return selection;
}

torch::Tensor LargestProduct(const FaceProducts& products)
{
  return SelectionStep::apply(products.Products, products.Bias, products.Selection, false);
}

torch::Tensor NormalizedLargestProduct(const FaceProducts& products)
{
  return SelectionStep::apply(products.Products, products.Bias, products.Selection, true);
}

} // namespace surfsynth
