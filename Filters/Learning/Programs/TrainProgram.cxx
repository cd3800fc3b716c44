// SPDX-License-Identifier: BSD-3-Clause
//
// surfacesynthesis-train: training without VTK, for machines that have only LibTorch.
//
//   surfacesynthesis-train flow-matching dataset.safetensors model.safetensors [option value]...
//
// Ends with 0 when the model is trained, 1 after an error, 2 when the arguments are wrong, 3 when it was interrupted (Ctrl-C:
// a checkpoint is written; the same command goes on from there).
#include "Core/Common/Errors.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace
{
using namespace surfsynth;

struct UsageError : std::exception
{
  explicit UsageError(std::string text)
    : Text(std::move(text))
  {
  }
  const char* what() const noexcept override { return this->Text.c_str(); }
  std::string Text;
};

template <typename Number>
Number Parse(const std::string& option, const std::string& text)
{
  std::istringstream stream(text);
  Number number{};
  // Streams read "-1" as the largest unsigned number.
  const bool belowRange = std::is_unsigned<Number>::value && text.find('-') != std::string::npos;
  if (belowRange || !(stream >> number) || !stream.eof())
  {
    throw UsageError(option + " is \"" + text + "\"; expected " +
      (std::is_integral<Number>::value ? "a whole number" : "a number") + (belowRange ? " of at least 0" : ""));
  }
  return number;
}

template <typename Value>
Value Choose(const std::string& option, const std::string& text, const std::map<std::string, Value>& values)
{
  const auto found = values.find(text);
  if (found != values.end())
  {
    return found->second;
  }
  std::string known;
  for (const auto& entry : values)
  {
    known += (known.empty() ? "" : ", ") + entry.first;
  }
  throw UsageError(option + " is \"" + text + "\"; expected one of " + known);
}

const std::map<std::string, NoiseModel> Noises = { { "matern", NoiseModel::Matern },
  { "per-vertex", NoiseModel::PerVertex }, { "white", NoiseModel::White }, { "unscreened", NoiseModel::Unscreened },
  { "spectral", NoiseModel::Spectral } };
const std::map<std::string, TrainingDevice> Devices = { { "auto", TrainingDevice::Auto },
  { "cpu", TrainingDevice::CPU }, { "cuda", TrainingDevice::CUDA } };
const std::map<std::string, bool> YesOrNo = { { "yes", true }, { "no", false } };

/// One option of the command line: what it stands for, and what takes its value.
struct CommandOption
{
  std::string Help;
  std::function<void(const std::string& value)> Set;
};

template <typename Number>
CommandOption NumberOption(const std::string& name, Number& target, const std::string& help)
{
  std::ostringstream standard;
  standard << target;
  return { help + " (" + standard.str() + ")",
    [name, &target](const std::string& value) { target = Parse<Number>(name, value); } };
}

struct FlowMatchingCommand
{
  FlowMatchingTrainingOptions Options;
  TrainingFiles Files;
  std::string Dataset;

  std::map<std::string, CommandOption> KnownOptions()
  {
    FlowMatchingTrainingOptions& o = this->Options;
    std::map<std::string, CommandOption> known;
    const auto number = [&known](const std::string& name, auto& target, const std::string& help)
    { known[name] = NumberOption(name, target, help); };
    number("--iterations", o.Iterations, "iterations in all, those of a checkpoint included");
    number("--batch", o.BatchSize, "samples in an iteration");
    number("--sources-per-batch", o.SourcesPerBatch, "surfaces that they come from");
    number("--width", o.Width, "hidden channels");
    number("--blocks", o.Blocks, "blocks of the network");
    number("--layers", o.ComplexLayers, "layers between gradients");
    number("--learning-rate", o.LearningRate, "of Adam");
    number("--learning-rate-factor", o.LearningRateFactor, "at each milestone");
    number("--clip", o.GradientClip, "largest norm of the gradient, 0: none");
    number("--vertex-weight", o.VertexWeight, "of the loss in velocities");
    number("--jacobian-weight", o.JacobianWeight, "of the loss in their gradients");
    number("--averaging", o.WeightAveraging, "of the weights, 0: none");
    number("--screening", o.Noise.Screening, "tau of the noise");
    number("--noise-scale", o.Noise.Scale, "factor of the noise, 0: as the data varies");
    number("--eigenpairs", o.Noise.Eigenpairs, "of spectral noise");
    number("--seed", o.Seed, "of everything random");
    number("--checkpoint-interval", this->Files.CheckpointInterval, "iterations between checkpoints");
    known["--milestone"] = { "iteration after which the learning rate falls; may be given several times (a quarter of all)",
      [&o](const std::string& value) { o.Milestones.push_back(Parse<std::int64_t>("--milestone", value)); } };
    known["--inner-products"] = { "yes or no: features of dot products (yes)",
      [&o](const std::string& value) { o.InnerProducts = Choose("--inner-products", value, YesOrNo); } };
    known["--noise"] = { "matern, per-vertex, white, unscreened or spectral (matern)",
      [&o](const std::string& value) { o.Noise.Model = Choose("--noise", value, Noises); } };
    known["--device"] = { "auto, cpu or cuda (auto)",
      [&o](const std::string& value) { o.Device = Choose("--device", value, Devices); } };
    known["--encoder"] = { "PoissonNet model file that predicts a positional encoding, for many surfaces (none)",
      [&o](const std::string& value) { o.Encoder = ReadPoissonNet(value); } };
    known["--checkpoint"] = { "file to go on from, and to write (the model's name with .checkpoint)",
      [this](const std::string& value) { this->Files.Checkpoint = value; } };
    known["--losses"] = { "table of the losses, CSV (the model's name with .csv)",
      [this](const std::string& value) { this->Files.LossTable = value; } };
    known["--resume"] = { "yes or no: go on from the checkpoint where there is one (yes)",
      [this](const std::string& value) { this->Files.Resume = Choose("--resume", value, YesOrNo); } };
    return known;
  }

  void Read(const std::vector<std::string>& arguments)
  {
    if (arguments.size() < 2)
    {
      throw UsageError("the dataset or the model is missing");
    }
    this->Dataset = arguments[0];
    this->Files.Model = arguments[1];
    this->Files.Checkpoint = arguments[1] + ".checkpoint";
    this->Files.LossTable = arguments[1] + ".csv";
    const std::map<std::string, CommandOption> known = this->KnownOptions();
    for (std::size_t k = 2; k < arguments.size(); k += 2)
    {
      const auto option = known.find(arguments[k]);
      if (option == known.end() || k + 1 == arguments.size())
      {
        throw UsageError(
          arguments[k] + (option == known.end() ? " is not known" : " has no value; expected one after it"));
      }
      option->second.Set(arguments[k + 1]);
    }
  }
};

std::atomic<bool> Interrupted{ false };

void Interrupt(int) { Interrupted = true; }

/// A line that is rewritten at most once a second: iterations, loss, time left.
class ProgressLine
{
public:
  explicit ProgressLine(std::int64_t iterations)
    : Iterations(iterations)
    , Clock(iterations)
  {
  }

  void Show(const TrainingStep& step)
  {
    this->Clock.Add(step);
    const auto now = std::chrono::steady_clock::now();
    const bool last = step.Iteration == this->Iterations;
    if (!last && now - this->Shown < std::chrono::seconds(1))
    {
      return;
    }
    this->Shown = now;
    // A shorter line leaves nothing of a longer one.
    std::printf("\r%-78s%s", this->Clock.Describe().c_str(), last ? "\n" : "");
    std::fflush(stdout);
  }

private:
  std::int64_t Iterations;
  TrainingClock Clock;
  std::chrono::steady_clock::time_point Shown = std::chrono::steady_clock::now() - std::chrono::seconds(2);
};

void PrintUsage(std::ostream& stream)
{
  stream << "usage: surfacesynthesis-train flow-matching DATASET MODEL [OPTION VALUE]...\n\nOptions, and what holds "
            "without them:\n";
  for (const auto& [name, option] : FlowMatchingCommand().KnownOptions())
  {
    stream << "  " << name << std::string(24 - name.size(), ' ') << option.Help << '\n';
  }
}

int Train(FlowMatchingCommand& command)
{
  std::signal(SIGINT, Interrupt);
  std::signal(SIGTERM, Interrupt);
  ProgressLine line(command.Options.Iterations);
  const auto observe = [&line](const TrainingStep& step)
  {
    line.Show(step);
    return !Interrupted;
  };
  TrainFlowMatching(ReadSignalDataset(command.Dataset), command.Options, command.Files, observe,
    [](double) { return !Interrupted; });
  std::cout << "wrote " << command.Files.Model << '\n';
  return 0;
}

/// Memory that tensors give back is kept: to fetch pages anew for each of them takes a third of a training's time.
void KeepMemory()
{
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}
}

int main(int argc, char* argv[])
{
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && (arguments[0] == "--help" || arguments[0] == "-h"))
  {
    PrintUsage(std::cout);
    return 0;
  }
  KeepMemory();
  FlowMatchingCommand command;
  try
  {
    if (arguments.empty() || arguments[0] != "flow-matching")
    {
      throw UsageError("what to train is missing; expected flow-matching");
    }
    command.Read({ arguments.begin() + 1, arguments.end() });
    return Train(command);
  }
  catch (const UsageError& error)
  {
    std::cerr << "surfacesynthesis-train: " << error.what() << ". --help lists what there is.\n";
    return 2;
  }
  catch (const Cancelled& error)
  {
    std::cerr << "\nsurfacesynthesis-train: " << error.what() << " The same command goes on from there.\n";
    return 3;
  }
  catch (const std::exception& error)
  {
    std::cerr << "\nsurfacesynthesis-train: " << error.what() << '\n';
    return 1;
  }
}
