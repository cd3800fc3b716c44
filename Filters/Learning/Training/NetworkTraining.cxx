// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/NetworkTraining.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace surfsynth
{

ModelTensor ToModelTensor(const torch::Tensor& tensor)
{
  const torch::Tensor values = tensor.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  const float* data = values.data_ptr<float>();
  return { values.sizes().vec(), std::vector<float>(data, data + values.numel()) };
}

torch::Tensor ReadTensor(
  const std::string& file, const TrainingCheckpoint& checkpoint, const std::string& name, const torch::Tensor& like)
{
  const auto found = checkpoint.Tensors.find(name);
  if (found == checkpoint.Tensors.end() || found->second.Shape != like.sizes().vec())
  {
    throw ModelMismatch(
      file + ": the tensor \"" + name + "\" is missing or has another shape; expected a checkpoint of this training.");
  }
  return torch::from_blob(const_cast<float*>(found->second.Values.data()), found->second.Shape, torch::kFloat32)
    .to(like.device(), torch::kFloat32, false, true);
}

AdamMoments ReadMoments(
  const std::string& file, const TrainingCheckpoint& checkpoint, const std::string& name, const torch::Tensor& like)
{
  AdamMoments moments{ ReadTensor(file, checkpoint, "adam_mean." + name, like),
    ReadTensor(file, checkpoint, "adam_square." + name, like) };
  if (moments.Square.lt(0.0).any().item<bool>())
  {
    throw ModelMismatch(file + ": the tensor \"adam_square." + name +
      "\" has negative numbers; expected means of squares, as a training writes them.");
  }
  return moments;
}

void RequireFiniteWeights(const std::vector<torch::Tensor>& weights, std::int64_t iteration)
{
  const torch::NoGradGuard noGradients;
  const bool finite = std::all_of(weights.begin(), weights.end(),
    [](const torch::Tensor& weight) { return torch::isfinite(weight).all().item<bool>(); });
  if (!finite)
  {
    throw SolverFailure("A weight is not finite after iteration " + std::to_string(iteration) +
      " of the training; expected a lower learning rate. The files of earlier iterations are as they were.");
  }
}

torch::Device ChooseDevice(TrainingDevice wanted)
{
  const bool available = torch::cuda::is_available();
  if (wanted == TrainingDevice::CUDA && !available)
  {
    throw InvalidInput("NetworkTraining: the device is CUDA and LibTorch finds none; expected Auto or CPU here.");
  }
  return wanted != TrainingDevice::CPU && available ? torch::kCUDA : torch::kCPU;
}

std::string NameOf(const torch::Device& device) { return device.is_cuda() ? "CUDA" : "CPU"; }

torch::Tensor ToTensor(const FeatureMatrix& matrix, const torch::Device& device)
{
  return torch::from_blob(const_cast<float*>(matrix.data()), { matrix.rows(), matrix.cols() }, torch::kFloat32)
    .to(device, torch::kFloat32, false, true);
}

namespace
{
LossHistory NetworkLossesByTime(const std::string& prefix)
{
  const LossHistory plain = NetworkLossHistory();
  std::vector<std::string> values(plain.Columns().begin() + 1, plain.Columns().end());
  AppendTimeColumns(values, prefix);
  return { { plain.Columns().front() }, values, "loss" };
}
} // namespace

NetworkTraining::NetworkTraining(
  const PoissonNetModel& initial, const TrainingOptions& options, const std::string& timePrefix)
  : Options(options)
  , Where(ChooseDevice(options.Device))
  , Net(MakePoissonNet(initial))
  , Losses(timePrefix.empty() ? NetworkLossHistory() : NetworkLossesByTime(timePrefix))
{
  this->Net->to(this->Where);
  std::vector<torch::Tensor> matrices;
  std::vector<torch::Tensor> others;
  for (const torch::Tensor& parameter : this->Net->parameters())
  {
    const bool isOfMuon = options.Optimizer == TrainingOptimizer::Muon && Muon::Moves(parameter);
    (isOfMuon ? matrices : others).push_back(parameter);
    this->Averages.push_back(parameter.detach().clone());
  }
  this->Adam = std::make_unique<torch::optim::Adam>(others, torch::optim::AdamOptions(options.LearningRate));
  this->Matrices = std::make_unique<Muon>(std::move(matrices));
}

torch::Tensor* NetworkTraining::MomentumOf(const torch::Tensor& parameter)
{
  const bool isOfMuon = this->Options.Optimizer == TrainingOptimizer::Muon && Muon::Moves(parameter);
  return isOfMuon ? &this->Matrices->MomentumOf(parameter) : nullptr;
}

double NetworkTraining::LearningRate() const
{
  if (this->Options.Schedule == LearningRateSchedule::Cosine)
  {
    const auto all = static_cast<double>(this->Options.Iterations);
    const auto done = static_cast<double>(this->Iteration());
    const double risen = std::min(1.0, 100.0 * (done + 1.0) / all);
    return this->Options.LearningRate * risen * 0.5 * (1.0 + std::cos(std::acos(-1.0) * std::min(1.0, done / all)));
  }
  const std::vector<std::int64_t> milestones = this->Options.Milestones.empty()
    ? std::vector<std::int64_t>{ this->Options.Iterations / 4 }
    : this->Options.Milestones;
  const auto passed = std::count_if(
    milestones.begin(), milestones.end(), [this](std::int64_t milestone) { return this->Iteration() >= milestone; });
  return this->Options.LearningRate * std::pow(this->Options.LearningRateFactor, static_cast<double>(passed));
}

void NetworkTraining::Step(const Objective& accumulate)
{
  const std::int64_t iteration = this->Iteration() + 1;
  const double learningRate = this->LearningRate();
  NetworkLosses losses;
  double gradientNorm = 0.0;
  const double limit = this->Options.GradientClip > 0.0 ? this->Options.GradientClip
                                                        : std::numeric_limits<double>::infinity();
  this->Net->zero_grad();
  bool finite = true;
  try
  {
    accumulate(losses);
    gradientNorm = torch::nn::utils::clip_grad_norm_(this->Net->parameters(), limit);
  }
  catch (const InvalidInput&) // the solver's, of a right-hand side that is not finite: all else was checked before
  {
    finite = false;
  }
  if (!finite || !std::isfinite(losses.Total) || !std::isfinite(gradientNorm))
  {
    throw SolverFailure("The loss or its gradient is not finite in iteration " + std::to_string(iteration) +
      " of the training; expected a lower learning rate, or samples without outliers.");
  }
  static_cast<torch::optim::AdamOptions&>(this->Adam->param_groups()[0].options()).lr(learningRate);
  this->Adam->step();
  this->Matrices->Step(learningRate);
  RequireFiniteWeights(this->Net->parameters(), iteration);
  this->UpdateAverages();
  std::vector<double> row = { static_cast<double>(iteration), losses.Total, losses.Vertex, losses.Jacobian,
    gradientNorm, learningRate };
  if (this->HasTimeLosses())
  {
    AppendTimeMeans(losses.ByTime, this->Losses, row);
  }
  this->Losses.Append(std::move(row));
}

bool NetworkTraining::HasTimeLosses() const
{
  return this->Losses.Columns().size() > NetworkLossHistory().Columns().size();
}

void NetworkTraining::UpdateAverages()
{
  const torch::NoGradGuard noGradients;
  const auto done = static_cast<double>(this->Iteration());
  const double keep = this->Options.WeightAveraging > 0.0
    ? std::min(this->Options.WeightAveraging, (1.0 + done) / (10.0 + done))
    : 0.0;
  const std::vector<torch::Tensor> parameters = this->Net->parameters();
  for (std::size_t k = 0; k < parameters.size(); ++k)
  {
    this->Averages[k].mul_(keep).add_(parameters[k], 1.0 - keep);
  }
}

PoissonNetModel NetworkTraining::Model()
{
  PoissonNetModel model = ModelOf(*this->Net);
  std::size_t number = 0;
  for (const auto& parameter : this->Net->named_parameters())
  {
    model.Tensors[parameter.key()] = ToModelTensor(this->Averages[number++]);
  }
  return model;
}

TrainingCheckpoint NetworkTraining::Checkpoint()
{
  TrainingCheckpoint checkpoint;
  const std::size_t columns = checkpoint.History.Columns().size();
  for (std::size_t k = 0; k < this->Losses.Size(); ++k)
  {
    const double* row = this->Losses.Row(k).data();
    checkpoint.History.Append({ row, row + columns });
  }
  if (this->HasTimeLosses())
  {
    checkpoint.Tensors[TimeLossesName] = TimeColumns(this->Losses);
  }
  std::size_t number = 0;
  for (const auto& parameter : this->Net->named_parameters())
  {
    const std::string& name = parameter.key();
    checkpoint.Tensors["network." + name] = ToModelTensor(parameter.value());
    checkpoint.Tensors["average." + name] = ToModelTensor(this->Averages[number++]);
    if (const torch::Tensor* momentum = this->MomentumOf(parameter.value()))
    {
      checkpoint.Tensors["momentum." + name] = ToModelTensor(*momentum);
      continue;
    }
    const AdamMoments moments = GetMoments(*this->Adam, parameter.value());
    if (moments.Mean.defined())
    {
      checkpoint.Tensors["adam_mean." + name] = ToModelTensor(moments.Mean);
      checkpoint.Tensors["adam_square." + name] = ToModelTensor(moments.Square);
    }
  }
  return checkpoint;
}

/// The history of a checkpoint, with the losses by time that its own table lacks.
LossHistory NetworkTraining::RestoredLosses(const std::string& file, const TrainingCheckpoint& checkpoint) const
{
  if (!this->HasTimeLosses())
  {
    return checkpoint.History;
  }
  const std::size_t rows = checkpoint.History.Size();
  const auto shape = { static_cast<std::int64_t>(rows), static_cast<std::int64_t>(NumberOfTimeLosses) };
  const ModelTensor byTime = ToModelTensor(ReadTensor(file, checkpoint, TimeLossesName, torch::empty(shape)));
  const std::vector<std::string>& columns = this->Losses.Columns();
  LossHistory history({ columns.front() }, { columns.begin() + 1, columns.end() }, "loss");
  for (std::size_t k = 0; k < rows; ++k)
  {
    std::vector<double> row = checkpoint.History.Row(k);
    AppendTimeRow(byTime, k, row);
    history.Append(std::move(row));
  }
  return history;
}

void NetworkTraining::Restore(const std::string& file, const TrainingCheckpoint& checkpoint)
{
  const torch::NoGradGuard noGradients;
  const auto parameters = this->Net->named_parameters();
  // All that can fail comes first, so that a training is not left half restored.
  std::vector<torch::Tensor> weights;
  std::vector<torch::Tensor> averages;
  std::vector<AdamMoments> moments; // of parameters of Muon the mean alone
  LossHistory losses = this->RestoredLosses(file, checkpoint);
  for (const auto& parameter : parameters)
  {
    const auto read = [&](const char* what) {
      return ReadTensor(file, checkpoint, what + parameter.key(), parameter.value());
    };
    weights.push_back(read("network."));
    averages.push_back(read("average."));
    moments.emplace_back();
    if (this->MomentumOf(parameter.value()))
    {
      moments.back().Mean = read("momentum.");
    }
    else if (!checkpoint.History.IsEmpty())
    {
      moments.back() = ReadMoments(file, checkpoint, parameter.key(), parameter.value());
    }
  }
  this->Losses = std::move(losses);
  this->Averages = std::move(averages);
  for (std::size_t k = 0; k < weights.size(); ++k)
  {
    torch::Tensor parameter = parameters[k].value();
    parameter.copy_(weights[k]);
    if (torch::Tensor* momentum = this->MomentumOf(parameter))
    {
      momentum->copy_(moments[k].Mean);
    }
    else if (moments[k].Mean.defined())
    {
      SetMoments(*this->Adam, parameter, moments[k], this->Iteration());
    }
  }
}

} // namespace surfsynth
