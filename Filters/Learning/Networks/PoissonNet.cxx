// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Networks/PoissonNet.h"

#include "Core/Common/Errors.h"

namespace surfsynth
{

namespace
{
std::string DescribeSizes(const torch::Tensor& tensor)
{
  return tensor.defined() ? c10::str(tensor.sizes()) : "undefined";
}
} // namespace

PoissonNetImpl::PoissonNetImpl(const PoissonNetOptions& options)
  : Architecture(options)
{
  CheckOptions(options);
  const std::int64_t width = options.Width;
  if (options.ExtraFeatures > 0)
  {
    this->ExtraMlp = this->register_module("extra_feat_mlp",
      torch::nn::Sequential(
        torch::nn::Linear(options.ExtraFeatures, width), torch::nn::GELU(), torch::nn::Linear(width, width)));
  }
  this->ProjectIn = this->register_module("proj_in", torch::nn::Linear(options.InputChannels, width));
  this->Blocks = this->register_module("blocks", torch::nn::ModuleList());
  for (std::int64_t block = 0; block < options.Blocks; ++block)
  {
    this->Blocks->push_back(PoissonBlock(options));
  }
  if (options.Head == PoissonNetHead::Linear)
  {
    this->LinearHead = this->register_module("head", torch::nn::Linear(width, options.OutputChannels));
  }
  else
  {
    this->IntegratingHead = this->register_module("head", GradientDomainHead(options));
  }
}

PoissonNetOutput PoissonNetImpl::forward(const MeshTensors& mesh, const torch::Tensor& x, const torch::Tensor& extra)
{
  if (!x.defined() || x.dim() < 2 || x.size(-2) != mesh.VertexMass.size(0) ||
    x.size(-1) != this->Architecture.InputChannels)
  {
    throw InvalidInput("PoissonNet: the input is " + DescribeSizes(x) + "; expected [..., " +
      std::to_string(mesh.VertexMass.size(0)) + ", " + std::to_string(this->Architecture.InputChannels) + "].");
  }
  const torch::Tensor condition = this->EmbedExtra(x, extra);
  torch::Tensor features = this->ProjectIn(x);
  for (const auto& block : *this->Blocks)
  {
    features = block->as<PoissonBlock>()->forward(mesh, features, condition);
  }
  if (this->IntegratingHead)
  {
    const IntegratedGradients result = this->IntegratingHead(mesh, features, x);
    return { result.Positions, result.Gradients };
  }
  const torch::Tensor logits = this->MapToDomain(mesh, this->LinearHead(features));
  return { this->Architecture.Activation == LastActivation::LogSoftmax ? torch::log_softmax(logits, -1) : logits, {} };
}

torch::Tensor PoissonNetImpl::EmbedExtra(const torch::Tensor& x, const torch::Tensor& extra)
{
  const std::int64_t count = this->Architecture.ExtraFeatures;
  const bool fits = count == 0 ? !extra.defined()
                               : extra.defined() && extra.size(-1) == count &&
      (extra.dim() == 1 || extra.size(-2) == 1 || extra.size(-2) == x.size(-2));
  if (!fits)
  {
    throw InvalidInput("PoissonNet: the extra features are " + DescribeSizes(extra) + "; expected " +
      (count == 0 ? "none" : "[" + std::to_string(count) + "] or [..., V or 1, " + std::to_string(count) + "]") + ".");
  }
  if (count == 0)
  {
    return {};
  }
  std::vector<std::int64_t> shape = x.sizes().vec();
  shape.back() = this->Architecture.Width;
  return this->ExtraMlp->forward(extra).expand(shape);
}

torch::Tensor PoissonNetImpl::MapToDomain(const MeshTensors& mesh, const torch::Tensor& logits) const
{
  switch (this->Architecture.Domain)
  {
    case PoissonNetDomain::Faces:
      return FaceMean(mesh, logits);
    case PoissonNetDomain::Global:
      return MassMean(mesh, logits).squeeze(-2);
    default:
      return logits;
  }
}

PoissonNet MakePoissonNet(const PoissonNetModel& model)
{
  CheckModel(model);
  PoissonNet network(model.Options);
  const torch::NoGradGuard noGradients;
  for (auto& parameter : network->named_parameters())
  {
    const ModelTensor& tensor = model.Tensors.at(parameter.key());
    parameter.value().copy_(torch::from_blob(const_cast<float*>(tensor.Values.data()), tensor.Shape, torch::kFloat32));
  }
  return network;
}

PoissonNetModel ModelOf(PoissonNetImpl& network)
{
  PoissonNetModel model;
  model.Options = network.Options();
  for (const auto& parameter : network.named_parameters())
  {
    const torch::Tensor values = parameter.value().detach().to(torch::kCPU, torch::kFloat32).contiguous();
    const float* data = values.data_ptr<float>();
    model.Tensors[parameter.key()] = { values.sizes().vec(), std::vector<float>(data, data + values.numel()) };
  }
  return model;
}

} // namespace surfsynth
