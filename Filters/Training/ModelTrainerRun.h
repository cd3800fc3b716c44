// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The training of one update of a vtkModelTrainer. Private to the module.
#pragma once

#include "BackgroundTraining.h"
#include "vtkModelTrainer.h"

#include "Core/Common/Progress.h"
#include "Learning/Training/ModelTrainer.h"
#include "Learning/Training/TrainingClock.h"
#include "Learning/Training/TrainingOptions.h"

#include <cstdint>
#include <string>

class vtkTable;

class vtkModelTrainer::Run : public surfsynth::TrainingWatch
{
public:
  /// @param table takes the losses; empty so far.
  Run(vtkModelTrainer* self, vtkTable* table, const surfsynth::Progress& progress);

  /// Runs @p job within this update, or starts it in the background; the output then has what it has reported so far.
  void Train(const surfsynth::TrainingJob& job);
  /// Gives what the training in the background has reported to the filter and its output. @throws its error.
  void ShowBackground();

  const surfsynth::Progress& GetProgress() const override { return this->Progress; }

  /// The files of the shared properties; the dataset file is an input. In the background there is no time budget.
  /// @throws InvalidInput when ModelFileName is empty.
  surfsynth::TrainingFiles Files() const;

  /// Sets learning rate, seed and device to those of the filter.
  void SetSharedOptions(surfsynth::ModelTrainingOptions& options) const;

  /// Shows iteration, loss and remaining time as progress text, says once the time to expect, and keeps the time for
  /// EndsEarly(). The run must outlive the result. @param stage comes before them.
  surfsynth::TrainingObserver ShowProgress(
    const surfsynth::TrainingClock& clock, const std::string& stage = "") override;

  /// True when the time budget has ended the training before its last iteration; gives the filter the time to expect for
  /// the others, and warns of it. @param what is trained, for the warning.
  bool EndsEarly(const surfsynth::ModelTrainer& trainer, const std::string& what) override;

  /// Gives iterations, device and losses of @p trainer to the filter and its output; EndsEarly().
  void Finish(const surfsynth::ModelTrainer& trainer) override;

private:
  vtkModelTrainer* Self;
  vtkTable* Table;
  surfsynth::Progress Progress;
  surfsynth::TrainingClock Clock{ 0 };
};
