// SPDX-License-Identifier: BSD-3-Clause
// Common parts of all trainings: losses, checks of options, and the training from the first iteration to the files.
#include "TrainingData.h"

#include "Core/Common/Errors.h"
#include "Learning/Training/EncodingTrainer.h"
#include "Learning/Training/GeometricTextureTrainer.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/MultiscaleMeshFitter.h"
#include "Learning/Training/OptionChecks.h"
#include "Learning/Training/TrainingCheckpoint.h"
#include "Learning/Training/TrainingClock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <thread>
#include <utility>

using namespace surfsynth;
using namespace surfsynth::test;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

namespace
{
/// A trainer whose losses are the reciprocals of the iterations, and whose model file names the iteration.
class CountingTrainer : public ModelTrainer
{
public:
  CountingTrainer(std::int64_t iterations, std::int64_t stage)
    : All(iterations)
    , Stage(stage)
  {}
  void Step() override
  {
    const auto iteration = static_cast<double>(this->Iteration() + 1);
    this->Losses.Append({ iteration, 1.0 / iteration, 0.0, 0.0, 0.0, 1e-3 });
  }
  std::int64_t Iterations() const override { return this->All; }
  const LossHistory& History() const override { return this->Losses; }
  bool IsAtEndOfStage() const override { return this->Iteration() % this->Stage == 0; }
  std::string DeviceName() const override { return "CPU"; }
  void SaveModel(const std::string& path) const override
  {
    std::ofstream(path) << this->Iteration();
    this->SavedAt.push_back(this->Iteration());
  }

  mutable std::vector<std::int64_t> SavedAt;

private:
  std::map<std::string, std::string> Recipe() const override { return { { "training", "counting" } }; }
  TrainingCheckpoint Checkpoint() const override
  {
    TrainingCheckpoint checkpoint;
    checkpoint.History = this->Losses;
    return checkpoint;
  }
  void Restore(const std::string&, const TrainingCheckpoint& checkpoint) override { this->Losses = checkpoint.History; }

  std::int64_t All;
  std::int64_t Stage;
  LossHistory Losses = NetworkLossHistory();
};

LossHistory Losses(int rows)
{
  LossHistory losses({ "iteration", "level" }, { "loss", "rate" }, "loss");
  for (int k = 0; k < rows; ++k)
  {
    losses.Append({ k + 1.0, 2.0, 100.0 - k, 0.1 });
  }
  return losses;
}

class TrainAndSaveFiles : public FlowMatchingTraining
{};
} // namespace

TEST(LossHistory, HasARowForEachIterationAndAColumnForEachQuantity)
{
  const LossHistory losses = Losses(3);
  EXPECT_THAT(losses.Columns(), ElementsAre("iteration", "level", "loss", "rate"));
  EXPECT_EQ(losses.NumberOfCounts(), 2u);
  EXPECT_EQ(losses.Size(), 3u);
  EXPECT_FALSE(losses.IsEmpty());
  EXPECT_TRUE(Losses(0).IsEmpty());
  EXPECT_THAT(losses.Row(1), ElementsAre(2.0, 2.0, 99.0, 0.1));
  EXPECT_EQ(losses.Value(2, "iteration"), 3.0);
  EXPECT_THAT(losses.Column("loss"), ElementsAre(100.0, 99.0, 98.0));
  EXPECT_EQ(losses.Last(), 98.0);
  EXPECT_TRUE(losses == Losses(3));
  EXPECT_FALSE(losses == Losses(2));
}

TEST(LossHistory, MeanOfTheLastTwentiethIsOfOneRowAtLeast)
{
  EXPECT_EQ(Losses(1).LastMean(), 100.0);
  EXPECT_EQ(Losses(39).LastMean(), 62.0);
  EXPECT_EQ(Losses(40).LastMean(), 61.5); // of 62 and 61
}

TEST(LossHistory, RefusesRowsOfAnotherLengthUnknownColumnsAndMeansOfNothing)
{
  LossHistory losses = Losses(1);
  EXPECT_THAT(TextOf<InvalidInput>([&] { losses.Append({ 1.0 }); }), HasSubstr("a row has 1 numbers; expected 4"));
  EXPECT_EQ(losses.Size(), 1u);
  EXPECT_THAT(TextOf<InvalidInput>([&] { losses.Column("none"); }),
    HasSubstr("no column \"none\"; expected one of iteration, level, loss, rate"));
  EXPECT_THROW(LossHistory({ "iteration" }, { "loss" }, "other"), InvalidInput);
  EXPECT_THROW(Losses(0).Last(), InvalidInput);
  EXPECT_THROW(Losses(0).LastMean(), InvalidInput);
}

TEST_F(TrainAndSaveFiles, LossesAreWrittenWithNineDigits)
{
  LossHistory losses({ "iteration" }, { "loss" }, "loss");
  losses.Append({ 1.0, 1.0 / 3.0 });
  losses.Append({ 123456789.0, 1e-20 });
  losses.WriteCsv(this->File("a.csv"));
  EXPECT_EQ(BytesOf(this->File("a.csv")), "iteration,loss\n1,0.333333333\n123456789,1e-20\n");
  EXPECT_THAT(TextOf<InvalidInput>([&] { losses.WriteCsv(this->File("absent/a.csv")); }), HasSubstr("cannot write"));
}

TEST_F(TrainAndSaveFiles, FilesAreWrittenAtIntervalsAfterStagesAndAtTheEnd)
{
  CountingTrainer trainer(11, 6);
  std::vector<double> fractions;
  TrainAndSave(trainer, this->Files("a"), {}, [&](double fraction) {
    fractions.push_back(fraction);
    return true;
  });
  EXPECT_THAT(trainer.SavedAt, ElementsAre(4, 6, 8, 11));
  EXPECT_EQ(BytesOf(this->File("a.safetensors")), "11");
  ASSERT_EQ(fractions.size(), 11u);
  EXPECT_DOUBLE_EQ(fractions.front(), 1.0 / 11.0);
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST_F(TrainAndSaveFiles, AStoppedTrainingGoesOnFromItsCheckpoint)
{
  const TrainingFiles files = this->Files("a");
  CountingTrainer first(9, 100);
  const auto stop = [](const LossHistory& losses) { return losses.Size() < 3; };
  EXPECT_THAT(TextOf<Cancelled>([&] { TrainAndSave(first, files, stop); }), HasSubstr("stopped after iteration 3"));
  EXPECT_THAT(first.SavedAt, ElementsAre(3));
  CountingTrainer second(9, 100);
  std::vector<std::size_t> seen;
  TrainAndSave(second, files, [&](const LossHistory& losses) {
    seen.push_back(losses.Size());
    return true;
  });
  EXPECT_THAT(seen, ElementsAre(4, 5, 6, 7, 8, 9));
  EXPECT_EQ(BytesOf(this->File("a.csv")).substr(0, 10), "iteration,");
  CountingTrainer complete(9, 100);
  TrainAndSave(complete, files);
  EXPECT_THAT(complete.SavedAt, ElementsAre(9)) << "the model is written again";
  CountingTrainer shorter(8, 100);
  EXPECT_THAT(TextOf<ModelMismatch>([&] { TrainAndSave(shorter, files); }),
    HasSubstr("the checkpoint is of iteration 9; expected at most the 8"));
}

TEST_F(TrainAndSaveFiles, TwoTrainingsDoNotWriteTheSameFiles)
{
  const TrainingFiles files = this->Files("a");
  CountingTrainer trainer(3, 3);
  int refused = 0;
  const auto trainAgain = [&](const LossHistory&) {
    CountingTrainer second(3, 3);
    EXPECT_THAT(
      TextOf<InvalidInput>([&] { TrainAndSave(second, files); }), HasSubstr("is being written by another training"));
    EXPECT_EQ(second.Iteration(), 0);
    ++refused;
    return true;
  };
  TrainAndSave(trainer, files, trainAgain);
  EXPECT_EQ(refused, 3);
  EXPECT_EQ(std::distance(fs::directory_iterator(this->Folder), fs::directory_iterator()), 3) << "a lock is left";
  CountingTrainer third(3, 3);
  TrainAndSave(third, files);
}

TEST_F(TrainAndSaveFiles, ATableIsNeverWrittenThroughALinkAndLeftoversGo)
{
  const TrainingFiles files = this->Files("a");
  std::ofstream(this->File("mine")) << "a file of the user";
  // Names that earlier versions wrote to, and that killed processes leave.
  fs::create_symlink(fs::absolute(this->File("mine")), files.LossTable + ".part");
  ASSERT_EQ(mkfifo((files.Model + ".part").c_str(), 0600), 0);
  const std::string leftover = files.Checkpoint + ".999999999-0.tmp"; // no process has this number
  std::ofstream(leftover) << "half";
  std::ofstream(files.Checkpoint + ".notes.tmp") << "the user's";
  CountingTrainer trainer(3, 3);
  TrainAndSave(trainer, files);
  EXPECT_EQ(BytesOf(this->File("mine")), "a file of the user");
  EXPECT_FALSE(fs::exists(leftover));
  EXPECT_TRUE(fs::exists(files.Checkpoint + ".notes.tmp"));
}

TEST_F(TrainAndSaveFiles, FilesAreCheckedBeforeTheFirstIteration)
{
  CountingTrainer trainer(3, 3);
  TrainingFiles files = this->Files("a");
  files.CheckpointInterval = 0;
  EXPECT_THAT(TextOf<InvalidInput>([&] { TrainAndSave(trainer, files); }), HasSubstr("the checkpoint interval is 0"));
  EXPECT_EQ(trainer.Iteration(), 0);
}

TEST_F(TrainAndSaveFiles, TheClockFollowsTheMonitoredLoss)
{
  CountingTrainer trainer(10, 10);
  TrainingClock clock(10);
  trainer.Step();
  clock.Add(trainer.History());
  EXPECT_EQ(clock.Describe(), "iteration 1 of 10, loss 1");
  trainer.Step();
  clock.Add(trainer.History());
  EXPECT_DOUBLE_EQ(clock.SmoothedLoss(), 0.98 + 0.02 * 0.5);
  EXPECT_THAT(clock.Describe(), HasSubstr("iteration 2 of 10, loss 0.99, 0:00:0"));
}

TEST(TrainingClock, StagesOfOtherCostCountForTheTimeLeft)
{
  TrainingClock clock(10, { 1.0, 4.0 });
  const auto begin = std::chrono::steady_clock::now();
  clock.Add(1);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  clock.Add(2);
  const double measured = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GE(clock.SecondsLeft(), 0.02 * (3 * 1 + 5 * 4));
  EXPECT_LE(clock.SecondsLeft(), measured * (3 * 1 + 5 * 4));
}

TEST(TrainingClock, TheForecastComesOnceAndOnlyForLongTrainings)
{
  TrainingClock clock(20000);
  TrainingClock brief(3);
  clock.Add(1);
  brief.Add(1);
  EXPECT_EQ(clock.TakeForecast(), "") << "before anything is measured";
  clock.Add(2);
  EXPECT_EQ(clock.TakeForecast(), "") << "after less than a second";
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  clock.Add(3);
  brief.Add(2);
  EXPECT_THAT(clock.TakeForecast(),
    testing::ContainsRegex("^The other 19997 of 20000 iterations take about [0-9]+:[0-9][0-9]:[0-9][0-9]\\.$"));
  EXPECT_EQ(clock.TakeForecast(), "");
  EXPECT_EQ(brief.TakeForecast(), "") << "less than a minute";
}

TEST(OptionChecks, EachCheckNamesOptionsOptionFoundAndExpected)
{
  const OptionChecks check("SomeOptions");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void()>>> cases = {
    { "SomeOptions: A is 0; expected 1 to 7.", [&] { check.Count("A", 0, 1, 7); } },
    { "SomeOptions: A is 8; expected 1 to 7.", [&] { check.Count("A", 8, 1, 7); } },
    { "SomeOptions: B is 0; expected 1 to 1e8.", [&] { check.Iterations("B", 0); } },
    { "SomeOptions: B is 100000001; expected 1 to 1e8.", [&] { check.Iterations("B", 100000001); } },
    { "SomeOptions: C is -0.5; expected a finite number of at least 0.", [&] { check.Weight("C", -0.5); } },
    { "SomeOptions: C is nan; expected a finite number of at least 0.", [&] { check.Weight("C", nan); } },
    { "SomeOptions: D is 0; expected a finite number above 0.", [&] { check.Positive("D", 0.0); } },
    { "SomeOptions: D is nan; expected a finite number above 0.", [&] { check.Positive("D", nan); } },
    { "SomeOptions: L is 1e+300; expected a number above 0 and at most 1e30.",
      [&] { check.LearningRate("L", 1e300); } },
    { "SomeOptions: L is nan; expected a number above 0 and at most 1e30.", [&] { check.LearningRate("L", nan); } },
    { "SomeOptions: E is 0; expected a number in (0, 1].", [&] { check.Factor("E", 0.0); } },
    { "SomeOptions: E is nan; expected a number in (0, 1].", [&] { check.Factor("E", nan); } },
    { "SomeOptions: F is 3; expected none.", [&] { check.Require(false, "F", 3.0, "none"); } },
  };
  for (const auto& [expected, call] : cases)
  {
    EXPECT_EQ(TextOf<InvalidInput>(call), expected);
  }
  EXPECT_NO_THROW(check.Count("A", 7, 1, 7));
  EXPECT_NO_THROW(check.Iterations("B", 100000000));
  EXPECT_NO_THROW(check.Weight("C", 0.0));
  EXPECT_NO_THROW(check.Positive("D", 1e-300));
  EXPECT_NO_THROW(check.Factor("E", 1.0));
}

TEST(OptionChecks, TheOptionsOfEachTrainingAreNamed)
{
  EncodingTrainingOptions encoding;
  encoding.Eigenfunctions = 0;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(encoding); }),
    HasSubstr("TrainingOptions: Eigenfunctions is 0; expected 1 to 10000"));
  GeometricTextureTrainingOptions texture;
  texture.LearningRate = -1.0;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(texture); }),
    HasSubstr("GeometricTextureTrainingOptions: LearningRate is -1; expected a number above 0 and at most 1e30"));
  MultiscaleFitOptions fit;
  fit.Levels = 11;
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckOptions(fit); }),
    HasSubstr("MultiscaleFitOptions: Levels is 11; expected 1 to 10"));
}
