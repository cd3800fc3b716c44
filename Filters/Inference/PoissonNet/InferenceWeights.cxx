// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/PoissonNet/InferenceWeights.h"

#include <Eigen/Core>

namespace surfsynth
{

namespace
{
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The tensors of a model by name.
class Reader
{
public:
  explicit Reader(const PoissonNetModel& model)
    : Model(model)
  {}
  bool Has(const std::string& name) const { return this->Model.Tensors.count(name) != 0; }
  const std::vector<float>& Vector(const std::string& name) const { return this->Model.Tensors.at(name).Values; }
  Matrix Weight(const std::string& name) const
  {
    const ModelTensor& tensor = this->Model.Tensors.at(name);
    using Single = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const Single>(tensor.Values.data(), tensor.Shape[0], tensor.Shape[1]).cast<double>();
  }
  AffineWeights Affine(const std::string& name) const;
  ComplexMlpWeights ComplexMlp(const std::string& name, std::int64_t layers) const;
  BlockWeights Block(const std::string& name) const;

private:
  const PoissonNetModel& Model;
};

std::vector<float> Transposed(const Matrix& matrix)
{
  std::vector<float> values(static_cast<std::size_t>(matrix.size()));
  Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
    values.data(), matrix.cols(), matrix.rows()) = matrix.transpose().cast<float>();
  return values;
}

ComplexWeights ThreeProducts(const Matrix& real, const Matrix& imaginary)
{
  return { Transposed(real), Transposed(imaginary - real), Transposed(real + imaginary) };
}

/// Multiplies the outputs of the map by diag(scale).
void ScaleOutputs(AffineWeights& affine, const std::vector<float>& scale)
{
  for (std::size_t k = 0; k < affine.Matrix.size(); ++k)
  {
    affine.Matrix[k] *= scale[k % scale.size()];
  }
  for (std::size_t k = 0; k < scale.size(); ++k)
  {
    affine.Bias[k] *= scale[k];
  }
}

AffineWeights Reader::Affine(const std::string& name) const
{
  return { Transposed(this->Weight(name + ".weight")), this->Vector(name + ".bias") };
}

ComplexMlpWeights Reader::ComplexMlp(const std::string& name, std::int64_t layers) const
{
  ComplexMlpWeights weights;
  const std::string modulator = name + ".modulator.modulator.";
  weights.Modulated = this->Has(modulator + "0.weight");
  if (weights.Modulated)
  {
    weights.ModulatorIn = this->Affine(modulator + "0");
    weights.ModulatorOut = this->Affine(modulator + "2");
  }
  for (std::int64_t layer = 0; layer < layers; ++layer)
  {
    const std::string prefix = name + ".layers." + std::to_string(layer);
    const Matrix real = this->Weight(prefix + ".lin_real.weight");
    const Matrix imaginary = this->Weight(prefix + ".lin_imag.weight");
    if (layer < layers - 1)
    {
      weights.Layers.push_back({ ThreeProducts(real, imaginary), this->Vector(prefix + ".mag_bias") });
    }
    else
    {
      weights.LastReal = Transposed(real);
      weights.LastImaginary = Transposed(imaginary);
    }
  }
  return weights;
}

BlockWeights Reader::Block(const std::string& name) const
{
  const PoissonNetOptions& options = this->Model.Options;
  BlockWeights weights;
  weights.GradientMlp = this->ComplexMlp(name + ".grad_mlp", options.ComplexLayers);
  if (options.InnerProducts)
  {
    const std::string last = name + ".grad_mlp.layers." + std::to_string(options.ComplexLayers - 1);
    const Matrix a = this->Weight(name + ".grad_features.lin_real.weight");
    const Matrix b = this->Weight(name + ".grad_features.lin_imag.weight");
    const Matrix c = this->Weight(last + ".lin_real.weight");
    const Matrix d = this->Weight(last + ".lin_imag.weight");
    weights.Products = ThreeProducts(a * c - b * d, a * d + b * c);
    weights.ProductScale = this->Vector(name + ".grad_scaler");
  }
  const Matrix first = this->Weight(name + ".vert_mlp.mlp1.layers.0.weight");
  Eigen::Index column = 0;
  const auto nextPart = [&] {
    column += options.Width;
    return Transposed(first.middleCols(column - options.Width, options.Width));
  };
  weights.FromFeatures = nextPart();
  weights.FromSolution = nextPart();
  weights.FromExtra = options.ExtraFeatures > 0 ? nextPart() : std::vector<float>();
  weights.FromProducts = options.InnerProducts ? nextPart() : std::vector<float>();
  weights.Bias1 = this->Vector(name + ".vert_mlp.mlp1.layers.0.bias");
  weights.Out1 = this->Affine(name + ".vert_mlp.mlp1.layers.3");
  ScaleOutputs(weights.Out1, this->Vector(name + ".vert_mlp.ls1"));
  weights.In2 = this->Affine(name + ".vert_mlp.mlp2.layers.0");
  weights.Out2 = this->Affine(name + ".vert_mlp.mlp2.layers.3");
  ScaleOutputs(weights.Out2, this->Vector(name + ".vert_mlp.ls2"));
  if (options.Normalize)
  {
    const std::string norm = name + ".vert_mlp.norm_";
    weights.SolutionNorm = { this->Vector(norm + "pde.weight"), this->Vector(norm + "pde.bias") };
    if (options.InnerProducts)
    {
      weights.ProductNorm = { this->Vector(norm + "grad.weight"), this->Vector(norm + "grad.bias") };
    }
  }
  return weights;
}
} // namespace

InferenceWeights::InferenceWeights(const PoissonNetModel& model)
{
  CheckModel(model);
  const Reader reader(model);
  this->ProjectIn = reader.Affine("proj_in");
  if (model.Options.ExtraFeatures > 0)
  {
    this->ExtraIn = reader.Affine("extra_feat_mlp.0");
    this->ExtraOut = reader.Affine("extra_feat_mlp.2");
  }
  for (std::int64_t block = 0; block < model.Options.Blocks; ++block)
  {
    this->Blocks.push_back(reader.Block("blocks." + std::to_string(block)));
  }
  if (model.Options.Head == PoissonNetHead::Linear)
  {
    this->LinearHead = reader.Affine("head");
  }
  else
  {
    this->GradientHead = reader.ComplexMlp("head.grad_mlp", model.Options.ComplexLayers);
  }
}

} // namespace surfsynth
