// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Errors.h"
#include "Learning/Training/FlowMatchingTrainer.h"

#include <array>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

namespace surfsynth
{

namespace
{
namespace fs = std::filesystem;

void Save(const FlowMatchingTrainer& trainer, const TrainingFiles& files)
{
  if (!files.Checkpoint.empty())
  {
    trainer.SaveCheckpoint(files.Checkpoint);
  }
  if (!files.Model.empty())
  {
    WriteFlowMatchingModel(files.Model, trainer.Model());
  }
  if (!files.LossTable.empty())
  {
    WriteLossTable(files.LossTable, trainer.History());
  }
}

/// What can be said of the files before hours of training.
void CheckFiles(const TrainingFiles& files)
{
  if (files.CheckpointInterval < 1)
  {
    throw InvalidInput("TrainFlowMatching: the checkpoint interval is " + std::to_string(files.CheckpointInterval) +
      "; expected at least 1.");
  }
  const std::array<std::pair<const char*, fs::path>, 3> places = { std::pair("model", fs::path(files.Model)),
    std::pair("checkpoint", fs::path(files.Checkpoint)), std::pair("loss table", fs::path(files.LossTable)) };
  for (std::size_t k = 0; k < places.size(); ++k)
  {
    const auto& [what, path] = places[k];
    std::error_code unknown;
    if (!path.empty() &&
      (!fs::is_directory(fs::absolute(path).parent_path(), unknown) || fs::is_directory(path, unknown)))
    {
      throw InvalidInput("TrainFlowMatching: the file of the " + std::string(what) + ", \"" + path.string() +
        "\", cannot be written: its folder does not exist, or it is a folder; expected the name of a file in a "
        "folder.");
    }
    for (std::size_t other = 0; !path.empty() && other < k; ++other)
    {
      if (fs::absolute(path).lexically_normal() == fs::absolute(places[other].second).lexically_normal())
      {
        throw InvalidInput("TrainFlowMatching: \"" + path.string() + "\" is the file of both the " +
          places[other].first + " and the " + what + "; expected a file for each.");
      }
    }
  }
}

/// Goes on from the checkpoint where that is wanted and there is one.
void Resume(FlowMatchingTrainer& trainer, const TrainingFiles& files)
{
  if (!files.Resume || files.Checkpoint.empty() || !fs::exists(files.Checkpoint))
  {
    return;
  }
  trainer.LoadCheckpoint(files.Checkpoint);
  if (trainer.Iteration() > trainer.Options().Iterations)
  {
    throw ModelMismatch(files.Checkpoint + ": the checkpoint is of iteration " + std::to_string(trainer.Iteration()) +
      "; expected at most the " + std::to_string(trainer.Options().Iterations) +
      " iterations of this training. Ask for more, or begin anew with another checkpoint file.");
  }
}
} // namespace

FlowMatchingTrainer TrainFlowMatching(SignalDataset dataset, const FlowMatchingTrainingOptions& options,
  const TrainingFiles& files, const TrainingObserver& observe, const Progress& progress)
{
  CheckFiles(files);
  FlowMatchingTrainer trainer(std::move(dataset), options, SubProgress(progress, 0.0, 0.02));
  Resume(trainer, files);
  if (trainer.Iteration() == options.Iterations)
  {
    Save(trainer, files); // nothing is left to do but that the files may have gone, or have other names
  }
  const Progress iterations = SubProgress(progress, 0.02, 1.0);
  while (trainer.Iteration() < options.Iterations)
  {
    const TrainingStep step = trainer.Step();
    const bool goOn = (!observe || observe(step)) &&
      (!iterations || iterations(static_cast<double>(step.Iteration) / static_cast<double>(options.Iterations)));
    const bool last = step.Iteration == options.Iterations;
    if (!goOn || last || step.Iteration % files.CheckpointInterval == 0)
    {
      Save(trainer, files);
    }
    if (!goOn && !last)
    {
      throw Cancelled("TrainFlowMatching: stopped after iteration " + std::to_string(step.Iteration) + ".");
    }
  }
  return trainer;
}

} // namespace surfsynth
