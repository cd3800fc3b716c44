// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/SampleGradients.h"

#include "Core/Common/Parallel.h"
#include "Core/Solvers/SingleThreadedBlas.h"

#include <ATen/Parallel.h>

#include <map>
#include <mutex>
#include <utility>

namespace surfsynth
{

namespace
{
/// Keeps torch on the calling thread while the object lives.
class SingleThreadedTorch
{
public:
  SingleThreadedTorch()
    : Before(at::get_num_threads())
  {
    at::set_num_threads(1);
  }
  ~SingleThreadedTorch() { at::set_num_threads(this->Before); }
  SingleThreadedTorch(const SingleThreadedTorch&) = delete;
  SingleThreadedTorch& operator=(const SingleThreadedTorch&) = delete;

private:
  int Before;
};

/// Sums of gradients that come in any order and are added in that of their samples.
class OrderedSums
{
public:
  explicit OrderedSums(std::size_t parameters)
    : Sums(parameters)
  {}

  /// Takes the gradients of a sample.
  void Add(std::int64_t sample, std::vector<torch::Tensor> gradients)
  {
    const std::lock_guard<std::mutex> lock(this->Mutex);
    this->Waiting.emplace(sample, std::move(gradients));
    while (!this->Waiting.empty() && this->Waiting.begin()->first == this->Next)
    {
      AddTo(this->Sums, this->Waiting.begin()->second);
      this->Waiting.erase(this->Waiting.begin());
      ++this->Next;
    }
  }

  /// Adds the sums to the gradients of the parameters.
  void AddToGradients(const std::vector<torch::Tensor>& parameters) const
  {
    for (std::size_t k = 0; k < parameters.size(); ++k)
    {
      torch::Tensor parameter = parameters[k];
      std::vector<torch::Tensor> gradient = { parameter.grad() };
      AddTo(gradient, { this->Sums[k] });
      parameter.mutable_grad() = gradient.front();
    }
  }

private:
  /// Undefined gradients are those of parameters that have no part in the loss.
  static void AddTo(std::vector<torch::Tensor>& sums, const std::vector<torch::Tensor>& gradients)
  {
    for (std::size_t k = 0; k < sums.size(); ++k)
    {
      if (gradients[k].defined())
      {
        sums[k] = sums[k].defined() ? sums[k].add_(gradients[k]) : gradients[k].clone();
      }
    }
  }

  std::mutex Mutex;
  std::map<std::int64_t, std::vector<torch::Tensor>> Waiting;
  std::int64_t Next = 0;
  std::vector<torch::Tensor> Sums;
};
} // namespace

bool ServesSampleGradients(const torch::Device& device, std::int64_t samples)
{
  return device.is_cpu() && samples >= at::get_num_threads();
}

void AddSampleGradients(const std::vector<torch::Tensor>& parameters, std::int64_t samples,
  const std::function<torch::Tensor(std::int64_t)>& loss)
{
  const SingleThreadedBlas blas;
  const ThreadScope threads(at::get_num_threads());
  const SingleThreadedTorch alone;
  OrderedSums sums(parameters.size());
  ParallelTasks(samples, [&](std::int64_t sample) {
    at::set_num_threads(1); // of this thread
    const ThreadScope one(1);
    sums.Add(sample, torch::autograd::grad({ loss(sample) }, parameters, {}, {}, false, true));
  });
  sums.AddToGradients(parameters);
}

} // namespace surfsynth
