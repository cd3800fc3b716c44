// SPDX-License-Identifier: BSD-3-Clause
//
// Training of flow matching models: what is kept in files, and what comes of files that are damaged, of something else,
// or cannot be written.
#include "TrainingData.h"

#include "RandomPoissonNet.h"
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "Inference/FlowMatching/FlowMatchingModel.h"
#include "Learning/Training/FlowMatchingTrainer.h"
#include "Learning/Training/TrainingCheckpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::HasSubstr;

namespace
{
namespace fs = std::filesystem;

/// Limits the size of the files that this process may write, as a full disk does.
class FileSizeLimit
{
public:
  explicit FileSizeLimit(rlim_t bytes)
  {
    this->PreviousHandler = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &this->Previous);
    rlimit limit = this->Previous;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit()
  {
    setrlimit(RLIMIT_FSIZE, &this->Previous);
    std::signal(SIGXFSZ, this->PreviousHandler);
  }

private:
  rlimit Previous{};
  void (*PreviousHandler)(int) = SIG_DFL;
};

/// Gives all numbers of the tensors of a checkpoint whose names begin with @p prefix a value.
void SetTensors(const std::string& file, const std::string& prefix, float value)
{
  TrainingCheckpoint checkpoint = ReadCheckpoint(file);
  for (auto& [name, tensor] : checkpoint.Tensors)
  {
    if (name.compare(0, prefix.size(), prefix) == 0)
    {
      std::fill(tensor.Values.begin(), tensor.Values.end(), value);
    }
  }
  WriteCheckpoint(file, checkpoint);
}
} // namespace

TEST_F(FlowMatchingTraining, ResumingGivesTheBitsOfAnUninterruptedTraining)
{
  for (const auto& [averaging, optimizer] :
    { std::pair{ 0.0, TrainingOptimizer::Adam }, { 0.9, TrainingOptimizer::Adam }, { 0.0, TrainingOptimizer::Muon } })
  {
    const SignalDataset dataset = DeformedSpheres(3);
    FlowMatchingTrainingOptions options = TinyRecipe(9);
    options.Width = 16; // Muon leaves smaller matrices to Adam
    options.WeightAveraging = averaging;
    options.Optimizer = optimizer;
    const FlowMatchingTrainer whole = Trained(dataset, options, 9);
    Trained(dataset, options, 4).SaveCheckpoint(this->File("checkpoint"));
    FlowMatchingTrainer resumed(dataset, options);
    resumed.LoadCheckpoint(this->File("checkpoint"));
    EXPECT_EQ(resumed.Iteration(), 4);
    for (int k = 4; k < 9; ++k)
    {
      resumed.Step();
    }
    EXPECT_EQ(Weights(resumed), Weights(whole)) << averaging << ", " << static_cast<int>(optimizer);
    EXPECT_EQ(resumed.History().Size(), 9u);
    EXPECT_TRUE(resumed.History() == whole.History());
  }
}

TEST_F(FlowMatchingTraining, ACancelledTrainingGoesOnFromTheIterationItStoppedIn)
{
  const SignalDataset dataset = DeformedSpheres(3);
  const FlowMatchingTrainingOptions options = TinyRecipe(11);
  TrainFlowMatching(dataset, options, this->Files("whole"));
  const std::string text = TextOf<Cancelled>([&] {
    TrainFlowMatching(
      dataset, options, this->Files("parts"), [](const LossHistory& losses) { return losses.Size() < 6; });
  });
  EXPECT_THAT(text, HasSubstr("iteration 6"));
  std::vector<std::int64_t> iterations;
  TrainFlowMatching(dataset, options, this->Files("parts"), [&](const LossHistory& losses) {
    iterations.push_back(static_cast<std::int64_t>(losses.Size()));
    return true;
  });
  EXPECT_THAT(iterations, ::testing::ElementsAre(7, 8, 9, 10, 11));
  EXPECT_EQ(BytesOf(this->File("parts.safetensors")), BytesOf(this->File("whole.safetensors")));
  EXPECT_EQ(BytesOf(this->File("parts.checkpoint")), BytesOf(this->File("whole.checkpoint")));
  EXPECT_EQ(BytesOf(this->File("parts.csv")), BytesOf(this->File("whole.csv")));
}

TEST_F(FlowMatchingTraining, ACompleteCheckpointIsEnoughToWriteTheModelAgain)
{
  const SignalDataset dataset = DeformedSpheres(2);
  TrainFlowMatching(dataset, TinyRecipe(6), this->Files("a"));
  const std::string model = BytesOf(this->File("a.safetensors"));
  fs::remove(this->File("a.safetensors"));
  int steps = 0;
  TrainFlowMatching(dataset, TinyRecipe(6), this->Files("a"), [&](const LossHistory&) {
    ++steps;
    return true;
  });
  EXPECT_EQ(steps, 0);
  EXPECT_EQ(BytesOf(this->File("a.safetensors")), model);
  const std::string text = TextOf<ModelMismatch>([&] { TrainFlowMatching(dataset, TinyRecipe(5), this->Files("a")); });
  EXPECT_THAT(text, HasSubstr("the checkpoint is of iteration 6; expected at most the 5"));
}

TEST_F(FlowMatchingTraining, MoreIterationsGoOnFromACompleteCheckpoint)
{
  const SignalDataset dataset = DeformedSpheres(2);
  FlowMatchingTrainingOptions options = TinyRecipe(6);
  options.Milestones = { 3 };
  TrainFlowMatching(dataset, options, this->Files("a"));
  options.Iterations = 9;
  TrainFlowMatching(dataset, options, this->Files("a"));
  TrainFlowMatching(dataset, options, this->Files("b"));
  EXPECT_EQ(BytesOf(this->File("a.safetensors")), BytesOf(this->File("b.safetensors")));
}

TEST_F(FlowMatchingTraining, WithoutResumingTheCheckpointIsReplaced)
{
  const SignalDataset dataset = DeformedSpheres(2);
  TrainingFiles files = this->Files("a");
  TrainFlowMatching(dataset, TinyRecipe(6), files);
  FlowMatchingTrainingOptions other = TinyRecipe(6);
  other.Seed = 5;
  files.Resume = false;
  TrainFlowMatching(dataset, other, files);
  FlowMatchingTrainer(dataset, other).LoadCheckpoint(files.Checkpoint);
}

TEST_F(FlowMatchingTraining, CheckpointsOfAnotherTrainingAreRefusedNamingWhatDiffers)
{
  const SignalDataset dataset = DeformedSpheres(2);
  const FlowMatchingTrainingOptions options = TinyRecipe(4);
  Trained(dataset, options, 2).SaveCheckpoint(this->File("checkpoint"));
  const auto refusal = [&](const SignalDataset& data, const FlowMatchingTrainingOptions& recipe) {
    FlowMatchingTrainer trainer(data, recipe);
    const auto before = Weights(trainer);
    const std::string text = TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(this->File("checkpoint")); });
    EXPECT_EQ(trainer.Iteration(), 0);
    EXPECT_EQ(Weights(trainer), before);
    return text;
  };
  FlowMatchingTrainingOptions other = options;
  other.Width = 9;
  EXPECT_THAT(refusal(dataset, other), HasSubstr("width = 8; expected 9"));
  other = options;
  other.LearningRate = 1e-3;
  EXPECT_THAT(refusal(dataset, other), HasSubstr("learning_rate = 0.0005"));
  other = options;
  other.Noise.Model = NoiseModel::White;
  EXPECT_THAT(refusal(dataset, other), HasSubstr("noise = 0; expected 2"));
  other = options;
  other.Seed = 1;
  EXPECT_THAT(refusal(dataset, other), HasSubstr("seed = 0; expected 1"));
  other = options;
  other.Optimizer = TrainingOptimizer::Muon;
  EXPECT_THAT(refusal(dataset, other), HasSubstr("optimizer = nothing; expected muon"));
  Trained(dataset, other, 2).SaveCheckpoint(this->File("checkpoint"));
  EXPECT_THAT(refusal(dataset, options), HasSubstr("optimizer = muon; expected a checkpoint without optimizer"));
  Trained(dataset, options, 2).SaveCheckpoint(this->File("checkpoint"));
  EXPECT_THAT(refusal(DeformedSpheres(3), options), HasSubstr("dataset = "));
  SignalDataset renamed = DeformedSpheres(2);
  renamed.SignalName = "Flow"; // the same numbers are no positions then
  EXPECT_THAT(refusal(renamed, options), HasSubstr("dataset = "));
}

TEST_F(FlowMatchingTraining, CheckpointsOfAnotherEncoderAreRefused)
{
  const SignalDataset dataset = DeformedSpheres(2);
  FlowMatchingTrainingOptions options = TinyRecipe(4);
  options.Encoder = RandomModel(TwoChannelEncoder(), 1);
  Trained(dataset, options, 1).SaveCheckpoint(this->File("checkpoint"));
  options.Encoder = RandomModel(TwoChannelEncoder(), 2);
  FlowMatchingTrainer trainer(dataset, options);
  const std::string text = TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(this->File("checkpoint")); });
  EXPECT_THAT(text, HasSubstr("encoder = 2 channels"));
}

TEST_F(FlowMatchingTraining, DamagedCheckpointsAreRefusedAndLeaveTheTrainerAsItIs)
{
  const SignalDataset dataset = DeformedSpheres(2);
  FlowMatchingTrainer trainer = Trained(dataset, TinyRecipe(8), 3);
  trainer.SaveCheckpoint(this->File("checkpoint"));
  const std::string bytes = BytesOf(this->File("checkpoint"));
  const auto before = Weights(trainer);
  for (const std::size_t size : { std::size_t(0), std::size_t(7), bytes.size() / 2, bytes.size() - 1 })
  {
    std::ofstream(this->File("cut"), std::ios::binary) << bytes.substr(0, size);
    EXPECT_THAT(TextOf<FormatError>([&] { trainer.LoadCheckpoint(this->File("cut")); }), HasSubstr("cut"));
  }
  EXPECT_THROW(trainer.LoadCheckpoint(this->File("absent")), InvalidInput);
  WriteFlowMatchingModel(this->File("model"), trainer.Model());
  EXPECT_THAT(TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(this->File("model")); }),
    HasSubstr("expected \"training_checkpoint\""));
  EXPECT_EQ(trainer.Iteration(), 3);
  EXPECT_EQ(Weights(trainer), before);
}

TEST_F(FlowMatchingTraining, CheckpointsWithoutAllLossesByTimeAreRefused)
{
  const SignalDataset dataset = DeformedSpheres(2);
  Trained(dataset, TinyRecipe(6), 4).SaveCheckpoint(this->File("checkpoint"));
  TrainingCheckpoint changed = ReadCheckpoint(this->File("checkpoint"));
  ASSERT_EQ(changed.Tensors.at("losses.time").Shape, (std::vector<std::int64_t>{ 4, 8 }));
  changed.Tensors["losses.time"] = { { 3, 8 }, std::vector<float>(24) };
  WriteCheckpoint(this->File("short"), changed);
  changed.Tensors.erase("losses.time");
  WriteCheckpoint(this->File("missing"), changed);
  FlowMatchingTrainer resumed(dataset, TinyRecipe(6));
  for (const char* name : { "short", "missing" })
  {
    EXPECT_THAT(TextOf<ModelMismatch>([&] { resumed.LoadCheckpoint(this->File(name)); }), HasSubstr("losses.time"));
    EXPECT_EQ(resumed.Iteration(), 0);
  }
}

TEST_F(FlowMatchingTraining, CheckpointsOfAnotherPoissonEquationAreRefused)
{
  const SignalDataset dataset = DeformedSpheres(2);
  Trained(dataset, TinyRecipe(4), 1).SaveCheckpoint(this->File("checkpoint"));
  TrainingCheckpoint earlier = ReadCheckpoint(this->File("checkpoint"));
  earlier.Recipe.erase("poisson_shift"); // versions that shifted by the identity
  WriteCheckpoint(this->File("earlier"), earlier);
  FlowMatchingTrainer trainer(dataset, TinyRecipe(4));
  EXPECT_THAT(TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(this->File("earlier")); }),
    HasSubstr("poisson_shift = nothing; expected mass"));
  trainer.LoadCheckpoint(this->File("checkpoint"));
  EXPECT_EQ(trainer.Iteration(), 1);
}

TEST_F(FlowMatchingTraining, ACheckpointWithNegativeMeansOfSquaresIsRefused)
{
  const SignalDataset dataset = DeformedSpheres(2);
  const TrainingFiles files = this->Files("a");
  const auto stop = [](const LossHistory& losses) { return losses.Size() < 3; };
  EXPECT_THROW(TrainFlowMatching(dataset, TinyRecipe(8), files, stop), Cancelled);
  SetTensors(files.Checkpoint, "adam_square.", -1e-3F);
  const std::string model = BytesOf(files.Model);
  EXPECT_THAT(TextOf<ModelMismatch>([&] { TrainFlowMatching(dataset, TinyRecipe(8), files); }),
    HasSubstr("has negative numbers"));
  EXPECT_EQ(BytesOf(files.Model), model);
}

TEST_F(FlowMatchingTraining, WeightsThatAreNotFiniteReachNoFile)
{
  const SignalDataset dataset = DeformedSpheres(2);
  const TrainingFiles files = this->Files("a");
  const auto stop = [](const LossHistory& losses) { return losses.Size() < 3; };
  EXPECT_THROW(TrainFlowMatching(dataset, TinyRecipe(8), files, stop), Cancelled);
  SetTensors(files.Checkpoint, "adam_mean.", 3e38F);
  SetTensors(files.Checkpoint, "adam_square.", 0.0F);
  const std::string model = BytesOf(files.Model);
  const std::string checkpoint = BytesOf(files.Checkpoint);
  EXPECT_THAT(TextOf<SolverFailure>([&] { TrainFlowMatching(dataset, TinyRecipe(8), files); }),
    HasSubstr("A weight is not finite after iteration 4 of the training; expected a lower learning rate"));
  EXPECT_EQ(BytesOf(files.Model), model);
  EXPECT_EQ(BytesOf(files.Checkpoint), checkpoint);
}

TEST_F(FlowMatchingTraining, AFullDiskLosesNoEarlierCheckpoint)
{
  const SignalDataset dataset = DeformedSpheres(2);
  const TrainingFiles files = this->Files("a");
  FlowMatchingTrainingOptions options = TinyRecipe(8);
  options.Milestones = { 8 };
  const auto stop = [](const LossHistory& losses) { return losses.Size() < 4; };
  EXPECT_THROW(TrainFlowMatching(dataset, options, files, stop), Cancelled);
  const std::string checkpoint = BytesOf(files.Checkpoint);
  const std::string model = BytesOf(files.Model);
  const std::string table = BytesOf(files.LossTable);
  {
    const FileSizeLimit limit(1000);
    EXPECT_THAT(TextOf<InvalidInput>([&] { TrainFlowMatching(dataset, options, files); }), HasSubstr("a.checkpoint"));
    LossHistory losses({ "iteration" }, { "loss" }, "loss");
    for (int k = 0; k < 1000; ++k)
    {
      losses.Append({ k + 1.0, 0.5 });
    }
    EXPECT_THROW(losses.WriteCsv(files.LossTable), InvalidInput);
  }
  EXPECT_EQ(BytesOf(files.Checkpoint), checkpoint);
  EXPECT_EQ(BytesOf(files.Model), model);
  EXPECT_EQ(BytesOf(files.LossTable), table);
  EXPECT_EQ(std::distance(fs::directory_iterator(this->Folder), fs::directory_iterator()), 3); // nothing half written
  EXPECT_EQ(TrainFlowMatching(dataset, options, files).Iteration(), 8);
}

TEST_F(FlowMatchingTraining, FilesThatCannotBeWrittenAreRefusedBeforeTheTraining)
{
  const SignalDataset dataset = DeformedSpheres(2);
  int steps = 0;
  const auto refusal = [&](const TrainingFiles& files) {
    return TextOf<InvalidInput>([&] {
      TrainFlowMatching(dataset, TinyRecipe(4), files, [&](const LossHistory&) {
        ++steps;
        return true;
      });
    });
  };
  TrainingFiles files = this->Files("a");
  files.Model = this->File("absent/a.safetensors");
  EXPECT_THAT(refusal(files), HasSubstr("the file of the model, "));
  files = this->Files("a");
  files.Checkpoint = this->Folder.string();
  EXPECT_THAT(refusal(files), HasSubstr("it is a folder"));
  ASSERT_EQ(mkfifo(this->File("pipe").c_str(), 0600), 0);
  files.Checkpoint = this->File("pipe");
  EXPECT_THAT(refusal(files), HasSubstr("or a device"));
  files = this->Files("a");
  files.LossTable = this->File("absent/a.csv");
  EXPECT_THAT(refusal(files), HasSubstr("the file of the loss table, "));
  files = this->Files("a");
  files.Checkpoint = this->File("./a.safetensors");
  EXPECT_THAT(refusal(files), HasSubstr("both the model and the checkpoint"));
  files = this->Files("a");
  files.Inputs = { "", this->File("../") + this->Folder.filename().string() + "/a.safetensors" };
  EXPECT_THAT(refusal(files), HasSubstr("the file of the model, "));
  files = this->Files("a");
  std::ofstream(files.Checkpoint) << "the other name of a file";
  std::filesystem::create_symlink(std::filesystem::absolute(files.Checkpoint), files.LossTable);
  EXPECT_THAT(refusal(files), HasSubstr("both the checkpoint and the loss table"));
  files = this->Files("a");
  files.CheckpointInterval = 0;
  EXPECT_THAT(refusal(files), HasSubstr("the checkpoint interval is 0; expected at least 1"));
  EXPECT_EQ(steps, 0);
}

TEST_F(FlowMatchingTraining, CheckpointsAreJudgedByTheirHeaders)
{
  const SignalDataset dataset = DeformedSpheres(2);
  const std::string path = this->File("checkpoint");
  Trained(dataset, TinyRecipe(3), 2).SaveCheckpoint(path);
  std::map<std::string, std::string> metadata;
  test::SparseTensors tensors;
  {
    const SafetensorsFile file(path);
    metadata = file.Metadata();
    for (const auto& [name, entry] : file.Tensors())
    {
      tensors[name] = { std::string(TypeName(entry.Type)), entry.Shape };
    }
  }
  FlowMatchingTrainer trainer(dataset, TinyRecipe(3));
  const auto refusal = [&](const std::string& name, std::int64_t rows, std::int64_t columns) {
    test::SparseTensors content = tensors;
    content[name] = { "F64", { rows, columns } };
    test::WriteSparseModel(path, content, metadata);
    return TextOf<ModelMismatch>([&] { trainer.LoadCheckpoint(path); });
  };
  const std::uint64_t before = test::PeakMemory();
  EXPECT_THAT(refusal("stranger", test::SparseBytes / 8, 1), HasSubstr("it is the checkpoint of another one"));
  EXPECT_THAT(refusal("history", test::SparseBytes / 48, 6),
    HasSubstr("the checkpoint is of iteration 357913941; expected at most the 3"));
  EXPECT_THAT(refusal("history", test::SparseBytes / 64, 8), HasSubstr("\"history\" is no table of six columns"));
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  EXPECT_EQ(trainer.Iteration(), 0);
}
