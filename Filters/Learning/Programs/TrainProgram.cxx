// SPDX-License-Identifier: BSD-3-Clause
//
// surfacesynthesis-train: training without VTK, for machines that have only LibTorch.
//
//   surfacesynthesis-train flow-matching dataset.safetensors model.safetensors [option value]...
//   surfacesynthesis-train encoding dataset.safetensors encoder.safetensors [option value]...
//   surfacesynthesis-train geometric-texture levels.safetensors model.safetensors [option value]...
//   surfacesynthesis-train field-latents textures.safetensors model.safetensors [option value]...
//   surfacesynthesis-train latent-diffusion latents.safetensors model.safetensors [option value]...
//
// Ends with 0 when the model is trained, 1 after an error, 2 when the arguments are wrong, 3 when it was interrupted (Ctrl-C:
// a checkpoint is written; the same command goes on from there). A training that --time-budget ends early ends with 0.
#include "Core/Common/Errors.h"
#include "Core/Solvers/BlasKernels.h"
#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/FieldLatentTrainer.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "Learning/Training/LatentDiffusionTrainer.h"
#include "Learning/Training/TrainingClock.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
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
  {}
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
  { "per_vertex", NoiseModel::PerVertex }, { "white", NoiseModel::White }, { "unscreened", NoiseModel::Unscreened },
  { "spectral", NoiseModel::Spectral } };
const std::map<std::string, std::optional<FlowPrediction>> Predictions = { { "automatic", std::nullopt },
  { "velocity", FlowPrediction::Velocity }, { "data", FlowPrediction::Data },
  { "preconditioned", FlowPrediction::Preconditioned } };
const std::map<std::string, TrainingOptimizer> Optimizers = { { "adam", TrainingOptimizer::Adam },
  { "muon", TrainingOptimizer::Muon } };
const std::map<std::string, LearningRateSchedule> Schedules = { { "milestones", LearningRateSchedule::Milestones },
  { "cosine", LearningRateSchedule::Cosine } };
const std::map<std::string, TrainingDevice> Devices = { { "auto", TrainingDevice::Auto },
  { "cpu", TrainingDevice::CPU }, { "cuda", TrainingDevice::CUDA } };
const std::map<std::string, FieldLatentCoordinates> Coordinates = {
  { "logarithmic", FieldLatentCoordinates::Logarithmic }, { "barycentric", FieldLatentCoordinates::Barycentric }
};
const std::map<std::string, FieldLatentOptions> Sizes = { { "paper", FieldLatentOptions::Paper() },
  { "small", FieldLatentOptions::Small() } };
const std::map<std::string, LatentDiffusionOptions> DiffusionSizes = { { "paper", LatentDiffusionOptions::Paper() },
  { "small", LatentDiffusionOptions::Small() } };
const std::map<std::string, DiffusionTarget> Targets = { { "noise", DiffusionTarget::Noise },
  { "data", DiffusionTarget::Data }, { "velocity", DiffusionTarget::Velocity } };
const std::map<std::string, TextureObjective> Objectives = { { "adversarial", TextureObjective::Adversarial },
  { "sliced_wasserstein", TextureObjective::SlicedWasserstein }, { "flow_matching", TextureObjective::FlowMatching } };
const std::map<std::string, bool> YesOrNo = { { "yes", true }, { "no", false } };

/// One option of the command line: its help text, and the function that takes its value.
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

using CommandOptions = std::map<std::string, CommandOption>;

template <typename Number>
void AddNumber(CommandOptions& known, const std::string& name, Number& target, const std::string& help)
{
  known[name] = NumberOption(name, target, help);
}

/// The name of an option; for a former one, with a warning, the name that it has now.
std::string CurrentName(const std::string& option)
{
  static const std::map<std::string, std::string> former = { { "--least-channels", "--minimum-channels" },
    { "--most-channels", "--maximum-channels" }, { "--name", "--texture-name" }, { "--noise", "--noise-model" },
    { "--samples", "--samples-per-ring" } };
  const auto found = former.find(option);
  if (found == former.end())
  {
    return option;
  }
  std::cerr << "surfacesynthesis-train: warning: " << option << " is deprecated: use " << found->second << ".\n";
  return found->second;
}

/// One kind of training on the command line: its options and its run.
class TrainCommand
{
public:
  virtual ~TrainCommand() = default;

  /// The options by name.
  virtual CommandOptions KnownOptions() = 0;
  /// Iterations in all, and the time of those of each stage.
  virtual TrainingClock Clock() const = 0;
  virtual void Train(const TrainingObserver& observe, const Progress& progress) = 0;

  void Read(const std::vector<std::string>& arguments)
  {
    if (arguments.size() < 2)
    {
      throw UsageError("the dataset or the model is missing");
    }
    this->Dataset = arguments[0];
    this->Files.Inputs = { arguments[0] };
    this->Files.Model = arguments[1];
    this->Files.Checkpoint = arguments[1] + ".checkpoint";
    this->Files.LossTable = arguments[1] + ".csv";
    const CommandOptions known = this->KnownOptions();
    for (std::size_t k = 2; k < arguments.size(); k += 2)
    {
      const auto option = known.find(CurrentName(arguments[k]));
      if (option == known.end() || k + 1 == arguments.size())
      {
        throw UsageError(
          arguments[k] + (option == known.end() ? " is not known" : " has no value; expected one after it"));
      }
      option->second.Set(arguments[k + 1]);
    }
  }

  const TrainingFiles& Results() const { return this->Files; }

protected:
  /// The options of the trainings of a PoissonNet.
  CommandOptions PoissonNetOptions(TrainingOptions& o)
  {
    CommandOptions known = this->SharedOptions(o);
    AddNumber(known, "--iterations", o.Iterations, "iterations in all, those of a checkpoint included");
    AddNumber(known, "--learning-rate-factor", o.LearningRateFactor, "at each milestone");
    AddNumber(known, "--clip", o.GradientClip, "largest norm of the gradient, 0: none");
    AddNumber(known, "--averaging", o.WeightAveraging, "of the weights, 0: none");
    AddNumber(known, "--width", o.Width, "hidden channels");
    AddNumber(known, "--blocks", o.Blocks, "blocks of the network");
    AddNumber(known, "--layers", o.ComplexLayers, "layers between gradients");
    known["--inner-products"] = { "yes or no: features of dot products (no)",
      [&o](const std::string& value) { o.InnerProducts = Choose("--inner-products", value, YesOrNo); } };
    known["--optimizer"] = { "muon, at rates of 0.01 to 0.02, or adam (muon)",
      [&o](const std::string& value) { o.Optimizer = Choose("--optimizer", value, Optimizers); } };
    known["--schedule"] = { "milestones or cosine: how the learning rate falls (cosine)",
      [&o](const std::string& value) { o.Schedule = Choose("--schedule", value, Schedules); } };
    known["--milestone"] = {
      "iteration after which the learning rate falls; may be given several times (a quarter of all)",
      [&o](const std::string& value) { o.Milestones.push_back(Parse<std::int64_t>("--milestone", value)); }
    };
    return known;
  }

  /// The options of every training: learning rate, seed, device and files.
  CommandOptions SharedOptions(ModelTrainingOptions& o)
  {
    CommandOptions known;
    AddNumber(known, "--learning-rate", o.LearningRate, "of the optimizer");
    AddNumber(known, "--seed", o.Seed, "of everything random");
    AddNumber(known, "--checkpoint-interval", this->Files.CheckpointInterval, "iterations between checkpoints");
    AddNumber(known, "--time-budget", this->Files.TimeBudget, "minutes, after which files are written; 0: no limit");
    known["--device"] = { "auto, cpu or cuda (auto)",
      [&o](const std::string& value) { o.Device = Choose("--device", value, Devices); } };
    known["--checkpoint"] = { "file to go on from, and to write (the model's name with .checkpoint)",
      [this](const std::string& value) { this->Files.Checkpoint = value; } };
    known["--losses"] = { "table of the losses, CSV (the model's name with .csv)",
      [this](const std::string& value) { this->Files.LossTable = value; } };
    known["--resume"] = { "yes or no: go on from the checkpoint where there is one (yes)",
      [this](const std::string& value) { this->Files.Resume = Choose("--resume", value, YesOrNo); } };
    return known;
  }

  TrainingFiles Files;
  std::string Dataset;
};

class FlowMatchingCommand : public TrainCommand
{
public:
  CommandOptions KnownOptions() override
  {
    FlowMatchingTrainingOptions& o = this->Options;
    CommandOptions known = this->PoissonNetOptions(o);
    AddNumber(known, "--batch", o.BatchSize, "samples in an iteration");
    AddNumber(known, "--sources-per-batch", o.SourcesPerBatch, "surfaces that they come from");
    AddNumber(known, "--source-memory", o.SourceMemory, "MiB, limit of the factorisations of surfaces that are kept");
    AddNumber(known, "--vertex-weight", o.VertexWeight, "of the loss in velocities");
    AddNumber(known, "--jacobian-weight", o.JacobianWeight, "of the loss in their gradients");
    AddNumber(known, "--screening", o.Noise.Screening, "tau of the noise");
    AddNumber(known, "--noise-smoothing", o.Noise.Smoothing, "in squared edge lengths; -1: 0 for positions, 1 else");
    AddNumber(known, "--noise-scale", o.Noise.Scale, "factor of the noise, 0: as the data varies");
    AddNumber(known, "--eigenpairs", o.Noise.Eigenpairs, "of spectral noise");
    known["--initial-model"] = {
      "model file whose training goes on; noise and network are its own, and the encoder without --encoder (none)",
      [this, &o](const std::string& value) {
        o.InitialModel = ReadFlowMatchingModel(value);
        this->Files.Inputs.push_back(value);
      }
    };
    known["--prediction"] = { "velocity, data or preconditioned: what the network predicts (automatic)",
      [&o](const std::string& value) { o.Prediction = Choose("--prediction", value, Predictions); } };
    known["--noise-model"] = { "matern, per_vertex, white, unscreened or spectral (matern)",
      [&o](const std::string& value) {
        o.Noise.Model = Choose("--noise-model", value == "per-vertex" ? "per_vertex" : value, Noises);
      } };
    known["--encoder"] = { "model file that \"encoding\" has trained, for many surfaces (none)",
      [this, &o](const std::string& value) {
        o.Encoder = ReadPoissonNet(value);
        this->Files.Inputs.push_back(value);
      } };
    known["--without-encoder"] = { "yes or no: surfaces of different shape without one, for comparison (no)",
      [&o](const std::string& value) { o.WithoutEncoder = Choose("--without-encoder", value, YesOrNo); } };
    return known;
  }
  TrainingClock Clock() const override { return TrainingClock(this->Options.Iterations); }
  void Train(const TrainingObserver& observe, const Progress& progress) override
  {
    TrainFlowMatching(ReadSignalDataset(this->Dataset), this->Options, this->Files, observe, progress);
  }

private:
  FlowMatchingTrainingOptions Options;
};

class EncodingCommand : public TrainCommand
{
public:
  CommandOptions KnownOptions() override
  {
    CommandOptions known = this->PoissonNetOptions(this->Options);
    AddNumber(known, "--batch", this->Options.BatchSize, "surfaces in an iteration");
    AddNumber(known, "--eigenfunctions", this->Options.Eigenfunctions, "channels of the encoding");
    AddNumber(
      known, "--encoder-edge-splits", this->Options.EdgeSplits, "largest part of the edges that are split at random");
    return known;
  }
  TrainingClock Clock() const override { return TrainingClock(this->Options.Iterations); }
  void Train(const TrainingObserver& observe, const Progress& progress) override
  {
    TrainEncoding(ReadSignalDataset(this->Dataset), this->Options, this->Files, observe, progress);
  }

private:
  EncodingTrainingOptions Options;
};

class TextureCommand : public TrainCommand
{
public:
  CommandOptions KnownOptions() override
  {
    GeometricTextureTrainingOptions& o = this->Options;
    CommandOptions known = this->SharedOptions(o);
    known["--iterations"] = { "iterations of each level, or one number for each, with commas between (2000)",
      [&o](const std::string& value) { SetIterations(value, o); } };
    known["--objective"] = {
      "adversarial, sliced_wasserstein or flow_matching: what generators learn by (flow_matching)",
      [&o](const std::string& value) { o.Objective = Choose("--objective", value, Objectives); }
    };
    AddNumber(known, "--flow-steps", o.FlowSteps, "of a flow at each level in a synthesis");
    AddNumber(known, "--base-noise-amplitude", o.BaseNoiseAmplitude,
      "of a flow: largest noise of the level before, in its mean edge lengths");
    AddNumber(known, "--base-samples", o.BaseSamples,
      "of a flow: samples of the level before that each level learns on; 0: the reference's");
    AddNumber(known, "--projections", o.Projections, "directions of the sliced Wasserstein distance in a step");
    AddNumber(known, "--discriminator-steps", o.DiscriminatorSteps, "in an iteration");
    AddNumber(known, "--generator-steps", o.GeneratorSteps, "in an iteration");
    AddNumber(known, "--learning-rate-interval", o.LearningRateInterval,
      "iterations of a level until it falls, 0: a quarter of them");
    AddNumber(known, "--learning-rate-factor", o.LearningRateFactor, "each time");
    AddNumber(known, "--penalty-weight", o.PenaltyWeight, "of the gradient penalty");
    AddNumber(
      known, "--penalty-interval", o.PenaltyInterval, "steps of the discriminator from one penalty to the next");
    AddNumber(known, "--reconstruction-weight", o.ReconstructionWeight, "of the distance from the reference");
    AddNumber(known, "--layers", o.Network.Layers, "convolutions of a network and one");
    AddNumber(known, "--start-channels", o.Network.StartChannels, "widest layer of level 0, doubled at each level");
    AddNumber(known, "--minimum-channels", o.Network.MinimumChannels, "of any layer");
    AddNumber(known, "--maximum-channels", o.Network.MaximumChannels, "of any layer");
    AddNumber(known, "--noise-amplitude", o.Network.NoiseAmplitude, "in mean edge lengths");
    known["--references"] = {
      "dataset file of the texture on another surface, of as many levels; may be given several times (none)",
      [this](const std::string& value) { this->Files.Inputs.push_back(value); }
    };
    known["--texture-name"] = { "of the texture (" + o.Name + ")", [&o](const std::string& value) { o.Name = value; } };
    return known;
  }
  /// Of all levels. @throws as ReadMultiscaleDataset().
  TrainingClock Clock() const override
  {
    const std::vector<MultiscaleDataset> references = this->References();
    return TrainingClock(IterationsOfEachLevel(this->Options, references.front().Levels.size()),
      CostsOfLevels(references, this->Options.Network));
  }
  void Train(const TrainingObserver& observe, const Progress& progress) override
  {
    TrainGeometricTexture(this->References(), this->Options, this->Files, observe, progress);
  }

private:
  /// @throws as ReadMultiscaleDataset().
  std::vector<MultiscaleDataset> References() const
  {
    std::vector<MultiscaleDataset> references;
    for (const std::string& path : this->Files.Inputs)
    {
      references.push_back(ReadMultiscaleDataset(path));
    }
    return references;
  }

  static void SetIterations(const std::string& value, GeometricTextureTrainingOptions& options)
  {
    std::istringstream list(value + ','); // so that also an empty text has a number that is missing
    std::vector<std::int64_t> iterations;
    for (std::string number; std::getline(list, number, ',');)
    {
      iterations.push_back(Parse<std::int64_t>("--iterations", number));
    }
    if (iterations.size() == 1)
    {
      options.IterationsPerLevel = iterations.front();
      iterations.clear();
    }
    options.IterationsOfLevels = iterations;
  }

  GeometricTextureTrainingOptions Options;
};

class FieldLatentCommand : public TrainCommand
{
public:
  CommandOptions KnownOptions() override
  {
    FieldLatentTrainingOptions& o = this->Options;
    CommandOptions known = this->SharedOptions(o);
    AddNumber(known, "--iterations", o.Iterations, "iterations in all, those of a checkpoint included");
    AddNumber(known, "--batch", o.BatchSize, "one-rings in an iteration");
    AddNumber(known, "--final-learning-rate", o.FinalLearningRate, "at the last iteration, along half a cosine");
    AddNumber(known, "--divergence-weight", o.DivergenceWeight, "of the Kullback-Leibler divergence");
    AddNumber(known, "--minimum-texels", o.MinimumTexels, "pixels for a vertex");
    AddNumber(known, "--maximum-texels", o.MaximumTexels, "pixels for a vertex");
    AddNumber(known, "--color-augmentation", o.ColorAugmentation, "part of the rings whose colors are changed");
    AddNumber(known, "--target-power", o.TargetPower, "of barycentric coordinates: density of the loss's points");
    AddNumber(known, "--clip", o.GradientClip, "largest norm of the gradient, 0: none");
    AddNumber(known, "--latent-dimension", o.Network.LatentDimension, "tangent vectors of a latent code");
    AddNumber(known, "--channels", o.Network.Channels, "of the encoder");
    AddNumber(known, "--encoder-layers", o.Network.EncoderLayers, "of the encoder");
    AddNumber(known, "--heads", o.Network.Heads, "of the attention, divides the channels");
    AddNumber(known, "--samples-per-ring", o.Network.SamplesPerRing, "points of a one-ring");
    AddNumber(known, "--decoder-layers", o.Network.DecoderLayers, "hidden layers of the decoder");
    AddNumber(known, "--decoder-width", o.Network.DecoderWidth, "channels of the decoder");
    known["--coordinates"] = { "logarithmic or barycentric (logarithmic)",
      [&o](const std::string& value) { o.Network.Coordinates = Choose("--coordinates", value, Coordinates); } };
    known["--sizes"] = { "small or paper: sizes of the networks, changed by later options (small)",
      [&o](const std::string& value) {
        const FieldLatentCoordinates coordinates = o.Network.Coordinates;
        o.Network = Choose("--sizes", value, Sizes);
        o.Network.Coordinates = coordinates;
      } };
    return known;
  }
  TrainingClock Clock() const override { return TrainingClock(this->Options.Iterations); }
  void Train(const TrainingObserver& observe, const Progress& progress) override
  {
    TrainFieldLatents(ReadTextureDataset(this->Dataset), this->Options, this->Files, observe, progress);
  }

private:
  FieldLatentTrainingOptions Options;
};

class LatentDiffusionCommand : public TrainCommand
{
public:
  CommandOptions KnownOptions() override
  {
    LatentDiffusionTrainingOptions& o = this->Options;
    CommandOptions known = this->SharedOptions(o);
    AddNumber(known, "--iterations", o.Iterations, "iterations in all, those of a checkpoint included");
    AddNumber(known, "--batch", o.BatchSize, "surfaces in an iteration");
    AddNumber(known, "--final-learning-rate", o.FinalLearningRate, "at the last iteration, along half a cosine");
    AddNumber(known, "--clip", o.GradientClip, "largest norm of the gradient, 0: none");
    AddNumber(known, "--averaging", o.WeightAveraging, "of the weights, 0: none");
    known["--optimizer"] = { "adam or muon (adam)",
      [&o](const std::string& value) { o.Optimizer = Choose("--optimizer", value, Optimizers); } };
    AddNumber(known, "--snr-limit", o.SnrLimit, "of the weights of the loss, 0: square error of the target");
    AddNumber(known, "--condition-dropout", o.ConditionDropout, "part of the surfaces without labels and directions");
    this->AddSizes(known);
    known["--target"] = { "noise, data or velocity: what the network predicts (noise)",
      [&o](const std::string& value) { o.Network.Target = Choose("--target", value, Targets); } };
    known["--sample-latents"] = { "yes or no: draw latents from their Gaussians, or take the means (yes)",
      [&o](const std::string& value) { o.SampleLatents = Choose("--sample-latents", value, YesOrNo); } };
    return known;
  }
  TrainingClock Clock() const override { return TrainingClock(this->Options.Iterations); }
  void Train(const TrainingObserver& observe, const Progress& progress) override
  {
    TrainLatentDiffusion(ReadLatentDataset(this->Dataset), this->Options, this->Files, observe, progress);
  }

private:
  void AddSizes(CommandOptions& known)
  {
    LatentDiffusionOptions& network = this->Options.Network;
    AddNumber(known, "--channels", network.Channels, "on the surface");
    AddNumber(known, "--coarse-channels", network.CoarseChannels, "on the coarser level");
    AddNumber(known, "--input-blocks", network.InputBlocks, "before the pooling");
    AddNumber(known, "--coarse-blocks", network.CoarseBlocks, "on the coarser level");
    AddNumber(known, "--output-blocks", network.OutputBlocks, "after the unpooling");
    AddNumber(known, "--embedding-dimension", network.EmbeddingDimension, "numbers of the embedding, even");
    AddNumber(known, "--time-steps", network.TimeSteps, "of the diffusion");
    AddNumber(known, "--first-variance", network.FirstVariance, "of the first step");
    AddNumber(known, "--last-variance", network.LastVariance, "of the last step");
    known["--sizes"] = { "small or paper: sizes of the network, changed by later options (small)",
      [&network](const std::string& value) {
        const LatentDiffusionOptions sizes = Choose("--sizes", value, DiffusionSizes);
        network.Channels = sizes.Channels;
        network.CoarseChannels = sizes.CoarseChannels;
        network.InputBlocks = sizes.InputBlocks;
        network.CoarseBlocks = sizes.CoarseBlocks;
        network.OutputBlocks = sizes.OutputBlocks;
        network.EmbeddingDimension = sizes.EmbeddingDimension;
      } };
  }

  LatentDiffusionTrainingOptions Options;
};

const char* const CommandNames[] = { "flow-matching", "encoding", "geometric-texture", "field-latents",
  "latent-diffusion" };

/// Null when there is nothing of that name.
std::unique_ptr<TrainCommand> MakeCommand(const std::string& name)
{
  if (name == "flow-matching")
  {
    return std::make_unique<FlowMatchingCommand>();
  }
  if (name == "geometric-texture")
  {
    return std::make_unique<TextureCommand>();
  }
  if (name == "field-latents")
  {
    return std::make_unique<FieldLatentCommand>();
  }
  if (name == "latent-diffusion")
  {
    return std::make_unique<LatentDiffusionCommand>();
  }
  return name == "encoding" ? std::make_unique<EncodingCommand>() : nullptr;
}

std::atomic<bool> Interrupted{ false };

void Interrupt(int) { Interrupted = true; }

/// A line that is rewritten at most once a second: iterations, loss, time left. Before it, once, the time to expect.
class ProgressLine
{
public:
  explicit ProgressLine(TrainingClock clock)
    : Clock(std::move(clock))
  {}

  /// The number of the last iteration shown; 0 before the first.
  std::int64_t Done() const { return this->Last; }

  void Show(const LossHistory& history)
  {
    this->Last = static_cast<std::int64_t>(history.Size());
    this->Clock.Add(history);
    const auto now = std::chrono::steady_clock::now();
    const bool last = this->Last == this->Clock.NumberOfIterations();
    const std::string forecast = this->Clock.TakeForecast();
    if (!forecast.empty())
    {
      std::printf("\r%-78s\n", forecast.c_str());
    }
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
  std::int64_t Last = 0;
  TrainingClock Clock;
  std::chrono::steady_clock::time_point Shown = std::chrono::steady_clock::now() - std::chrono::seconds(2);
};

void PrintUsage(std::ostream& stream)
{
  stream << "usage: surfacesynthesis-train flow-matching DATASET MODEL [OPTION VALUE]...\n"
            "       surfacesynthesis-train encoding DATASET MODEL [OPTION VALUE]...\n"
            "       surfacesynthesis-train geometric-texture DATASET MODEL [OPTION VALUE]...\n"
            "       surfacesynthesis-train field-latents DATASET MODEL [OPTION VALUE]...\n"
            "       surfacesynthesis-train latent-diffusion DATASET MODEL [OPTION VALUE]...\n";
  for (const char* name : CommandNames)
  {
    stream << "\nOptions of " << name << ", and what holds without them:\n";
    for (const auto& [option, known] : MakeCommand(name)->KnownOptions())
    {
      stream << "  " << option << std::string(26 - option.size(), ' ') << known.Help << '\n';
    }
  }
}

/// Says how matrix products become faster, where OpenBLAS does not know the processor and nobody chose its kernels.
void SuggestBlasKernels()
{
  const std::string wider = WiderBlasKernels();
  if (!wider.empty() && !std::getenv("OPENBLAS_CORETYPE"))
  {
    std::cerr << "Note: OpenBLAS does not use the AVX-512 of this processor. With OPENBLAS_CORETYPE=" << wider
              << " in the environment, matrix products take about half of the time.\n";
  }
}

int Train(TrainCommand& command)
{
  SuggestBlasKernels();
  std::signal(SIGINT, Interrupt);
  std::signal(SIGTERM, Interrupt);
  const TrainingClock clock = command.Clock();
  const std::int64_t iterations = clock.NumberOfIterations();
  ProgressLine line(clock);
  const auto observe = [&line](const LossHistory& history) {
    line.Show(history);
    return !Interrupted;
  };
  command.Train(observe, [](double) { return !Interrupted; });
  if (line.Done() > 0 && line.Done() < iterations)
  {
    std::cout << "\nThe time budget ended the training after iteration " << line.Done() << " of " << iterations
              << ". The same command goes on from " << command.Results().Checkpoint << '\n';
  }
  std::cout << "wrote " << command.Results().Model << '\n';
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
} // namespace

int main(int argc, char* argv[])
{
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && (arguments[0] == "--help" || arguments[0] == "-h"))
  {
    PrintUsage(std::cout);
    return 0;
  }
  KeepMemory();
  const std::unique_ptr<TrainCommand> command = MakeCommand(arguments.empty() ? "" : arguments[0]);
  try
  {
    if (!command)
    {
      throw UsageError(
        "what to train is missing; expected flow-matching, encoding, geometric-texture, field-latents or "
        "latent-diffusion");
    }
    command->Read({ arguments.begin() + 1, arguments.end() });
    return Train(*command);
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
