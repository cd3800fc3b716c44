// SPDX-License-Identifier: BSD-3-Clause
//
// surfacesynthesis-train from outside: arguments, files, exit status, signals.
#include "ExampleMeshes.h"
#include "SmallLatents.h"
#include "SmallTextures.h"
#include "TrainingData.h"

#include "Core/Solvers/BlasKernels.h"
#include "IO/Datasets/MultiscaleDataset.h"
#include "IO/Datasets/SignalDataset.h"
#include "IO/Datasets/TextureDataset.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Inference/FieldLatents/LatentDiffusionModel.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Inference/GeometricTexture/GeometricTextureModel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{
namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

/// A run of the program, with what it prints in a file.
class ProgramRun
{
public:
  ProgramRun(const Arguments& arguments, std::string output)
    : Output(std::move(output))
  {
    Arguments line = { SURFSYNTH_TRAIN_PROGRAM };
    line.insert(line.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& argument : line)
    {
      pointers.push_back(argument.data());
    }
    pointers.push_back(nullptr);
    const int file = open(this->Output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666); // before Text() reads
    this->Process = fork();
    if (this->Process == 0)
    {
      dup2(file, STDOUT_FILENO);
      dup2(file, STDERR_FILENO);
      execv(pointers[0], pointers.data());
      _exit(127);
    }
    close(file);
  }
  ~ProgramRun()
  {
    if (!this->Ended)
    {
      kill(this->Process, SIGKILL);
      waitpid(this->Process, nullptr, 0);
    }
  }
  ProgramRun(const ProgramRun&) = delete;
  ProgramRun& operator=(const ProgramRun&) = delete;

  void Signal(int number) const { kill(this->Process, number); }
  /// The exit status; -1 when a signal ended the program.
  int Status()
  {
    int status = 0;
    EXPECT_EQ(waitpid(this->Process, &status, 0), this->Process);
    this->Ended = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string Text() const { return BytesOf(this->Output); }

private:
  std::string Output;
  pid_t Process = -1;
  bool Ended = false;
};

class TrainProgram : public ::testing::Test
{
protected:
  void SetUp() override
  {
    this->Folder = fs::path("TrainProgram") / ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(this->Folder);
    fs::create_directories(this->Folder);
    WriteSignalDataset(this->File("data.safetensors"), DeformedSpheres(3));
  }
  std::string File(const std::string& name) const { return (this->Folder / name).string(); }

  /// The arguments of a training of a tiny network.
  Arguments Training(const std::string& model, const Arguments& more) const
  {
    Arguments arguments = { "flow-matching", this->File("data.safetensors"), this->File(model), "--width", "8",
      "--blocks", "2", "--layers", "2", "--batch", "2", "--device", "cpu", "--milestone", "2" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  void Expect(const Arguments& arguments, int status, const std::string& text) const
  {
    ProgramRun run(arguments, this->File("output"));
    EXPECT_EQ(run.Status(), status) << run.Text();
    EXPECT_THAT(run.Text(), HasSubstr(text));
  }

  fs::path Folder;
};
} // namespace

TEST_F(TrainProgram, HelpNamesEachOptionWithItsDefault)
{
  ProgramRun run({ "--help" }, this->File("output"));
  EXPECT_EQ(run.Status(), 0);
  for (const char* text : { "usage: surfacesynthesis-train flow-matching DATASET MODEL", "--iterations ", "(20000)",
         "--noise-model ", "--device ", "--resume ", "--checkpoint-interval ", "(500)", "--encoder ",
         "Options of latent-diffusion", "--snr-limit " })
  {
    EXPECT_THAT(run.Text(), HasSubstr(text));
  }
}

TEST_F(TrainProgram, WrongArgumentsAreStatus2)
{
  this->Expect({}, 2, "expected flow-matching");
  this->Expect({ "texture" }, 2, "expected flow-matching");
  this->Expect({ "flow-matching", this->File("data.safetensors") }, 2, "the dataset or the model is missing");
  this->Expect(this->Training("m", { "--depth", "3" }), 2, "--depth is not known");
  this->Expect(this->Training("m", { "--seed" }), 2, "--seed has no value");
  this->Expect(this->Training("m", { "--seed", "-1" }), 2, "--seed is \"-1\"; expected a whole number of at least 0");
  this->Expect(this->Training("m", { "--iterations", "1.5" }), 2, "--iterations is \"1.5\"; expected a whole number");
  this->Expect(this->Training("m", { "--learning-rate", "fast" }), 2, "expected a number");
  this->Expect(this->Training("m", { "--noise-model", "pink" }), 2, "expected one of matern, per_vertex, spectral");
  // Former names are understood, with a warning.
  this->Expect(this->Training("m", { "--noise", "pink" }), 2, "--noise is deprecated: use --noise-model");
  this->Expect(this->Training("m", { "--noise", "per-vertex", "--seed", "-1" }), 2, "--seed is \"-1\"");
  EXPECT_FALSE(fs::exists(this->File("m")));
}

TEST_F(TrainProgram, ErrorsAreStatus1)
{
  this->Expect({ "flow-matching", this->File("absent"), this->File("m") }, 1, "absent");
  this->Expect(this->Training("m", { "--width", "0" }), 1, "Width is 0; expected 1 to 100000");
  this->Expect(this->Training("absent/m", {}), 1, "the file of the model");
  const std::string data = BytesOf(this->File("data.safetensors"));
  this->Expect(this->Training("data.safetensors", {}), 1, "is one that the training is made from");
  this->Expect(this->Training("m", { "--losses", this->File("data.safetensors") }), 1, "the file of the loss table");
  EXPECT_EQ(BytesOf(this->File("data.safetensors")), data);
  this->Expect(this->Training("m", { "--encoder", this->File("data.safetensors") }), 1, "data.safetensors");
  EXPECT_FALSE(fs::exists(this->File("m")));
}

TEST_F(TrainProgram, SuggestsKernelsOfTheBlasOnlyWhereNobodyChoseThem)
{
  const char* const variable = "OPENBLAS_CORETYPE";
  const char* const before = std::getenv(variable);
  const std::string chosen = before ? before : "";
  const auto says = [&] {
    ProgramRun run(this->Training("m", { "--iterations", "1", "--resume", "no" }), this->File("output"));
    EXPECT_EQ(run.Status(), 0) << run.Text();
    return run.Text().find(variable) != std::string::npos;
  };
  setenv(variable, "Haswell", 1); // present on every processor that has wider ones
  EXPECT_FALSE(says());
  unsetenv(variable);
  // The kernels of this process are those of a program that is started without the variable, unless it was chosen.
  if (chosen.empty())
  {
    EXPECT_EQ(says(), !WiderBlasKernels().empty());
  }
  else
  {
    setenv(variable, chosen.c_str(), 1);
  }
}

TEST_F(TrainProgram, TrainsAndResumesToTheBytesOfAnUninterruptedTraining)
{
  // The course of a cosine depends on the number of all iterations.
  const auto training = [this](const char* name, const char* iterations) {
    return this->Training(name, { "--iterations", iterations, "--schedule", "milestones", "--milestone", "2" });
  };
  this->Expect(training("parts", "4"), 0, "wrote " + this->File("parts"));
  EXPECT_EQ(ReadFlowMatchingModel(this->File("parts")).Iterations, 4);
  this->Expect(training("parts", "7"), 0, "iteration 7 of 7, loss ");
  this->Expect(training("whole", "7"), 0, "wrote ");
  for (const char* kind : { "", ".checkpoint", ".csv" })
  {
    EXPECT_EQ(BytesOf(this->File(std::string("parts") + kind)), BytesOf(this->File(std::string("whole") + kind)))
      << kind;
  }
  this->Expect(this->Training("parts", { "--iterations", "7", "--seed", "1" }), 1, "seed = 0; expected 1");
  this->Expect(this->Training("parts", { "--iterations", "7", "--seed", "1", "--resume", "no" }), 0, "wrote ");
}

TEST_F(TrainProgram, TrainsOnShapesWithoutAnEncoderWithinAnyMemory)
{
  SignalDataset dataset = DeformedSpheres(2, 1);
  dataset.Sources.push_back(DeformedSpheres(3, 2).Sources[0]);
  dataset.Sources[1].Mesh.Points.col(2) *= 2.0;
  WriteSignalDataset(this->File("data.safetensors"), dataset);
  this->Expect(this->Training("refused", { "--iterations", "4" }), 1, "the 2 surfaces have different shapes");
  const Arguments plain = { "--iterations", "4", "--without-encoder", "yes" };
  Arguments limited = plain;
  limited.insert(limited.end(), { "--source-memory", "0" });
  this->Expect(this->Training("plain", plain), 0, "wrote ");
  this->Expect(this->Training("limited", limited), 0, "wrote ");
  EXPECT_EQ(BytesOf(this->File("plain")), BytesOf(this->File("limited")));
  this->Expect(this->Training("refused", { "--source-memory", "-1" }), 1, "SourceMemory is -1; expected");
}

TEST_F(TrainProgram, TrainsFieldLatents)
{
  WriteTextureDataset(this->File("textures.safetensors"), SmallTextures());
  const auto training = [this](const std::string& model, const Arguments& more) {
    Arguments arguments = { "field-latents", this->File("textures.safetensors"), this->File(model), "--channels", "8",
      "--encoder-layers", "1", "--heads", "2", "--samples-per-ring", "6", "--decoder-layers", "2", "--decoder-width",
      "12", "--batch", "6", "--device", "cpu" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  this->Expect(
    training("latents", { "--iterations", "3", "--coordinates", "barycentric" }), 0, "iteration 3 of 3, loss ");
  const FieldLatentModel model = ReadFieldLatents(this->File("latents"));
  EXPECT_EQ(model.Iterations, 3);
  EXPECT_EQ(model.Options.DecoderWidth, 12);
  EXPECT_EQ(model.Options.Coordinates, FieldLatentCoordinates::Barycentric);
  this->Expect(training("m", { "--sizes", "large" }), 2, "--sizes is \"large\"; expected one of paper, small");
  this->Expect(training("m", { "--iterations", "1", "--heads", "3" }), 1, "Heads is 3; expected a divisor of the 8");
  this->Expect({ "field-latents", this->File("data.safetensors"), this->File("m") }, 1, "expected \"textures\"");
}

TEST_F(TrainProgram, TrainsADiffusionOfFieldLatents)
{
  WriteLatentDataset(this->File("latents.safetensors"), SmallLatents());
  const auto training = [this](const std::string& model, const Arguments& more) {
    Arguments arguments = { "latent-diffusion", this->File("latents.safetensors"), this->File(model), "--channels", "4",
      "--coarse-channels", "6", "--coarse-blocks", "1", "--output-blocks", "1", "--embedding-dimension", "6", "--batch",
      "2", "--device", "cpu" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  this->Expect(training("m", { "--iterations", "2", "--target", "velocity" }), 0, "iteration 2 of 2, loss ");
  const LatentDiffusionModel model = ReadLatentDiffusion(this->File("m"));
  EXPECT_EQ(model.Iterations, 2);
  EXPECT_EQ(model.Options.CoarseChannels, 6);
  EXPECT_EQ(model.Options.LatentDimension, 2);
  EXPECT_EQ(model.Options.NumberOfLabels, 3);
  EXPECT_EQ(model.Options.Target, DiffusionTarget::Velocity);
  this->Expect(
    training("n", { "--target", "score" }), 2, "--target is \"score\"; expected one of data, noise, velocity");
  this->Expect(training("n", { "--sizes", "large" }), 2, "--sizes is \"large\"; expected one of paper, small");
  this->Expect(training("n", { "--condition-dropout", "2" }), 1, "ConditionDropout is 2; expected a number in [0, 1]");
  this->Expect(
    { "latent-diffusion", this->File("data.safetensors"), this->File("n") }, 1, "expected \"field_latents\"");
}

TEST_F(TrainProgram, ATimeBudgetEndsTheTrainingAndTheSameCommandGoesOn)
{
  const Arguments budget = this->Training("m", { "--iterations", "2", "--time-budget", "1e-9" });
  this->Expect(budget, 0, "The time budget ended the training after iteration 1 of 2.");
  EXPECT_EQ(ReadFlowMatchingModel(this->File("m")).Iterations, 1);
  this->Expect(budget, 0, "iteration 2 of 2, loss ");
  this->Expect(this->Training("m", { "--time-budget", "-1" }), 1, "the time budget is -1 minutes");
}

TEST_F(TrainProgram, ASignalLeavesACheckpointToGoOnFrom)
{
  for (const int number : { SIGINT, SIGTERM })
  {
    fs::remove(this->File("m.csv"));
    fs::remove(this->File("m.checkpoint"));
    ProgramRun run(this->Training("m", { "--iterations", "100000000", "--batch", "2", "--checkpoint-interval", "1" }),
      this->File("output"));
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(100);
    const std::string forecast = " of 100000000 iterations take about ";
    const auto isAwaited = [&] {
      const bool isSaid = number == SIGTERM || run.Text().find(forecast) != std::string::npos;
      return !isSaid || !fs::exists(this->File("m.csv"));
    };
    while (isAwaited() && std::chrono::steady_clock::now() < end)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    run.Signal(number);
    EXPECT_EQ(run.Status(), 3) << run.Text();
    EXPECT_THAT(run.Text(), HasSubstr("stopped after iteration "));
    EXPECT_THAT(run.Text(), HasSubstr("The same command goes on from there."));
    EXPECT_TRUE(fs::exists(this->File("m.checkpoint")));
    const std::int64_t done = ReadFlowMatchingModel(this->File("m")).Iterations;
    EXPECT_GE(done, 1);
    this->Expect(this->Training("m", { "--iterations", std::to_string(done + 1) }), 0, "wrote ");
  }
}

TEST_F(TrainProgram, TrainsAGeometricTexture)
{
  MultiscaleDataset dataset;
  dataset.Levels = { Icosphere(0) };
  WriteMultiscaleDataset(this->File("levels.safetensors"), dataset);
  this->Expect(
    { "geometric-texture", this->File("levels.safetensors"), this->File("texture.safetensors"), "--iterations", "2",
      "--texture-name", "bumps", "--start-channels", "4", "--minimum-channels", "4", "--device", "cpu" },
    0, "wrote ");
  EXPECT_EQ(ReadGeometricTexture(this->File("texture.safetensors")).Name, "bumps");
  const std::vector<std::string> both = { "geometric-texture", this->File("levels.safetensors"),
    this->File("both.safetensors"), "--references", this->File("torus.safetensors"), "--start-channels", "4",
    "--minimum-channels", "4", "--device", "cpu", "--learning-rate-interval", "0", "--penalty-interval", "2",
    "--iterations" };
  const auto with = [&both](const std::string& iterations) {
    std::vector<std::string> arguments = both;
    arguments.push_back(iterations);
    return arguments;
  };
  dataset.Levels = { Torus(8, 6) };
  WriteMultiscaleDataset(this->File("torus.safetensors"), dataset);
  this->Expect(with("2"), 0, "iteration 2 of 2");
  this->Expect(with("2,1"), 1, "IterationsOfLevels has 2 entries");
  this->Expect(with("2,x"), 2, "--iterations is \"x\"; expected a whole number");
  for (const char* incomplete : { "", ",", "2,", ",2" })
  {
    this->Expect(with(incomplete), 2, "--iterations is \"\"; expected a whole number");
  }
  this->Expect({ "geometric-texture", this->File("data.safetensors"), this->File("texture.safetensors") }, 1,
    "expected \"multiscale_surface\"");
}
