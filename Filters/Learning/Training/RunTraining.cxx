// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Errors.h"
#include "Learning/Training/TrainingOptions.h"

#include <string>

namespace surfsynth
{

void RunTraining(std::int64_t iterationsDone, const TrainingOptions& options, const TrainingFiles& files,
  const std::function<TrainingStep()>& step, const std::function<void()>& save, const TrainingObserver& observe,
  const Progress& progress)
{
  if (files.CheckpointInterval < 1)
  {
    throw InvalidInput("The checkpoint interval of the training is " + std::to_string(files.CheckpointInterval) +
      "; expected at least 1.");
  }
  bool saved = false;
  for (std::int64_t done = iterationsDone; done < options.Iterations;)
  {
    const TrainingStep result = step();
    done = result.Iteration;
    const bool goOn = (!observe || observe(result)) &&
      (!progress || progress(static_cast<double>(done) / static_cast<double>(options.Iterations)));
    saved = !goOn || done == options.Iterations || done % files.CheckpointInterval == 0;
    if (saved)
    {
      save();
    }
    if (!goOn && done < options.Iterations)
    {
      throw Cancelled("The training was stopped after iteration " + std::to_string(done) + ".");
    }
  }
  if (!saved)
  {
    save(); // a checkpoint that had it all already
  }
}

} // namespace surfsynth
