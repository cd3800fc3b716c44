// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkModelTrainer
 * @brief   Superclass of the filters that train models
 *
 * Properties, results and files that all trainings share. A subclass adds the parameters of its own model and trains it
 * in Train().
 *
 * @par Input
 * Those of the subclass. They may be left unconnected when DatasetFileName is set, and are not used then.
 *
 * @par Output
 * A vtkTable with a row for each iteration, those before a checkpoint included, and a column for each loss, which the
 * subclass names; the first is iteration (vtkIdType), from 1 on. Empty inputs give an empty table and no file.
 *
 * @par Files
 * The model is written to ModelFileName at the end, and as it then is with every checkpoint. A checkpoint is written
 * every CheckpointInterval iterations, at the end, and when the update is aborted; an interrupted training loses at
 * most the iterations after the last one, and the next update goes on from there. A file is replaced only when the new
 * one is complete: a full disk, which is an error, loses no earlier checkpoint. A checkpoint of other data or another
 * recipe is an error that names what differs.
 *
 * @par Progress
 * The progress text says the iteration, the loss and the remaining time. A training of a minute or more says once, after
 * its first iterations, the time to expect: as text of vtkCommand::MessageEvent or, without an observer of it, in VTK's
 * output window; in the background, BackgroundState has it. An aborted update writes its files within one
 * iteration and gives an empty table. ParaView before 6.2 cannot abort an update: give it a TimeBudget or Background there.
 *
 * @par Errors
 * One error and an empty table for: no input, or no model file name; an option out of its range; CUDA asked for and
 * absent; a file that is damaged, cannot be written, or would be written over another of the training's; a loss that is
 * not finite. Inputs on several MPI ranks are an error on all of them.
 *
 * @sa vtkFieldLatentTrainer, vtkFlowMatchingTrainer, vtkGeometricTextureTrainer
 */

#ifndef vtkModelTrainer_h
#define vtkModelTrainer_h

#include "vtkSurfaceSynthesisTrainingModule.h" // For export macro
#include "vtkTableAlgorithm.h"

#include <limits> // For std::numeric_limits
#include <memory> // For std::unique_ptr
#include <string> // For std::string

namespace surfsynth
{
class BackgroundTraining;
} // namespace surfsynth

class VTKSURFACESYNTHESISTRAINING_EXPORT vtkModelTrainer : public vtkTableAlgorithm
{
public:
  vtkAbstractTypeMacro(vtkModelTrainer, vtkTableAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The devices of a training.
  enum Devices
  {
    AUTO = 0, ///< CUDA where LibTorch finds a device, else the processor
    CPU = 1,
    CUDA = 2
  };

  ///@{
  /**
   * Path of the model file that is written. Must be set. Model files are in safetensors format. Default "".
   */
  void SetModelFileName(const char* name);
  vtkGetCharFromStdStringMacro(ModelFileName);
  ///@}

  ///@{
  /**
   * Path of the checkpoint. Empty (the default) stands for ModelFileName with .checkpoint after it.
   */
  void SetCheckpointFileName(const char* name);
  vtkGetCharFromStdStringMacro(CheckpointFileName);
  ///@}

  ///@{
  /**
   * Path of a table of the losses in comma-separated values, with the columns of the output, written with each
   * checkpoint. Default "": none.
   */
  void SetLossTableFileName(const char* name);
  vtkGetCharFromStdStringMacro(LossTableFileName);
  ///@}

  ///@{
  /**
   * Number of iterations from one checkpoint to the next; at least 1. Default 500.
   */
  vtkSetClampMacro(CheckpointInterval, int, 1, VTK_INT_MAX);
  vtkGetMacro(CheckpointInterval, int);
  ///@}

  ///@{
  /**
   * Continuation of the training from the checkpoint where there is one. Off: an update begins anew, and the checkpoint
   * is replaced. Default on.
   */
  vtkSetMacro(Resume, bool);
  vtkGetMacro(Resume, bool);
  vtkBooleanMacro(Resume, bool);
  ///@}

  ///@{
  /**
   * Time budget of an update in minutes, at least 0; 0 for no limit. When it is used up, after one iteration at least, the
   * files are written as at the end, the output has the losses so far, and a warning says the time that the other
   * iterations take; the next update goes on from there. A short budget measures that time. With a budget the number of
   * iterations of an update depends on the machine; the iterations themselves do not. Default 0.
   */
  vtkSetClampMacro(TimeBudget, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TimeBudget, double);
  ///@}

  ///@{
  /**
   * Training in the background: an update starts it on a thread of its own and returns at once with the losses so far; later
   * updates (Modified() and Update(), in ParaView Execute Again) look after it and change nothing else, until it has ended.
   * StopBackground() stops it, and so do the end of this object and an update without Background. The files are those of a
   * training within an update. TimeBudget is not used, and changed properties count from the next start on. Default off.
   */
  vtkSetMacro(Background, bool);
  vtkGetMacro(Background, bool);
  vtkBooleanMacro(Background, bool);
  ///@}

  /**
   * Stops a training in the background within one iteration, when it has written its files; the next update shows what it has
   * done, and the one after that goes on from the checkpoint. Does nothing without such a training.
   */
  void StopBackground();

  /**
   * State of the training in the background, as it is now: empty without one, else "running: ", "finished: ", "stopped: " or
   * "failed: " with iteration, loss and remaining time.
   */
  const char* GetBackgroundState() const;

  ///@{
  /**
   * Path of a dataset file that is trained on in place of the inputs. Dataset files are in safetensors format. Default
   * "": none.
   */
  void SetDatasetFileName(const char* name);
  vtkGetCharFromStdStringMacro(DatasetFileName);
  ///@}

  ///@{
  /**
   * Learning rate of the optimizer, larger than 0. Default 5e-4.
   */
  vtkSetClampMacro(LearningRate, double, 1e-300, std::numeric_limits<double>::max());
  vtkGetMacro(LearningRate, double);
  ///@}

  ///@{
  /**
   * Seed of everything random: the first weights, the noise, and the order of the samples. Any integer; the same seed
   * gives the same model. Default 0.
   */
  vtkSetMacro(Seed, int);
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /**
   * Device of the training. AUTO takes CUDA where LibTorch finds a device, else the processor; CUDA without a device is
   * an error. Default AUTO.
   */
  vtkSetClampMacro(Device, int, AUTO, CUDA);
  vtkGetMacro(Device, int);
  void SetDeviceToAuto() { this->SetDevice(AUTO); }
  void SetDeviceToCPU() { this->SetDevice(CPU); }
  void SetDeviceToCUDA() { this->SetDevice(CUDA); }
  ///@}

  /**
   * Number of iterations that the model of the last update has been trained for, those of a checkpoint included; 0 when
   * there is none.
   */
  vtkTypeInt64 GetNumberOfIterationsDone() const;

  /**
   * Estimated time in minutes of the iterations that the TimeBudget left out of the last update; 0 when there are none, or
   * fewer than two were done.
   */
  double GetRemainingTime() const;

  /**
   * Device of the last update, "CPU" or "CUDA"; empty when there was none.
   */
  const char* GetDeviceInUse() const;

protected:
  vtkModelTrainer();
  ~vtkModelTrainer() override;

  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override;

  /// The training of one update: progress, shared options and files, and the place of the results.
  class Run;

  /// Reads inputs whose reading updates filters upstream. Called on every rank of a parallel pipeline before one of them
  /// trains; keeps its errors for Train(). Does nothing here.
  virtual void ReadInputs(vtkInformationVector** inputVector);

  /// Trains, writes the files and gives the trainer to Run::Finish(); does nothing for empty inputs. Throws the errors
  /// that the update is to report.
  virtual void Train(vtkInformationVector** inputVector, Run& run) = 0;

  /// Sets a property to a text, to "" for a null pointer; calls Modified() on change only.
  void SetText(std::string& property, const char* text);

private:
  vtkModelTrainer(const vtkModelTrainer&) = delete;
  void operator=(const vtkModelTrainer&) = delete;

  std::string ModelFileName;
  std::string CheckpointFileName;
  std::string LossTableFileName;
  int CheckpointInterval = 500;
  bool Resume = true;
  double TimeBudget = 0.0;
  bool Background = false;
  std::string DatasetFileName;
  double LearningRate = 5e-4;
  int Seed = 0;
  int Device = AUTO;

  vtkTypeInt64 NumberOfIterationsDone = 0;
  double RemainingTime = 0.0;
  std::string DeviceInUse;
  mutable std::string BackgroundState;
  std::unique_ptr<surfsynth::BackgroundTraining> Task;
};

#endif
