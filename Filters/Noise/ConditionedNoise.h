// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random fields given observations. Private to the module.
#pragma once

#include "BlockCache.h"
#include "ObservationReading.h"
#include "SurfaceBridge.h"

#include "Core/Noise/FieldConditioning.h"
#include "Core/Noise/MaternField.h"
#include "Core/Noise/SurfaceDisplacement.h"

#include <vtkDataSet.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Properties of a filter that conditions its noise.
struct ConditioningSettings
{
  ObservationNames Names;          ///< arrays of the observations
  double Tolerance = 0.0;          ///< see AttachToSurface(), AttachToVolume()
  bool PosteriorMean = false;      ///< adds <OutputArrayName>_Mean
  bool PosteriorDeviation = false; ///< adds <OutputArrayName>_StandardDeviation
  std::int64_t MemoryLimit = 0;    ///< MiB, see SampleMemory
  std::string OutputArrayName;     ///< of the samples
  bool Targets = false;            ///< for displacements: the values are positions that the places take
};

/// Observations of the last update and the systems of their covariances, which are kept while surface, field, places
/// and deviations stay the same: other values take no new factorisation.
class ConditionedNoise
{
public:
  /// Begins an update with these observations; null for none.
  void Begin(vtkSmartPointer<vtkPolyData> observations, ConditioningSettings settings)
  {
    this->Given = std::move(observations);
    this->Settings = std::move(settings);
    this->UnreachedDistance = 0.0;
    this->Blocks.Begin();
  }
  /// Forgets what the update has not used.
  void DropUnused() { this->Blocks.DropUnused(); }
  /// Forgets the system of a block whose field is made anew.
  void Drop(const Surface& surface) { this->Blocks.Drop(surface); }
  /// True when there are observations.
  bool HasObservations() const { return this->Given != nullptr; }
  /// Number of systems of observations assembled and factored since this object was made.
  std::int64_t NumberOfSystems() const { return this->Systems; }

  /// Largest length of the parts of observed displacements that the directions exclude, world units, since Begin().
  double LargestUnreachedDistance() const { return this->UnreachedDistance; }

  /// Displacement of a surface, null for fields that are no displacements.
  using Displacement = std::shared_ptr<const SurfaceDisplacement>;

  /// Replaces samples of the prior by samples of the posterior.
  /// @param displacement for fields that are to become displacements; else null
  /// @param samples V * C doubles for each sample of @p request, in order; the fields of @p displacement
  /// @return "", or a warning of observed displacements that the directions exclude
  /// @throws InvalidInput, naming observations, arrays or properties; SolverFailure; Cancelled.
  std::string Condition(const Surface& surface, const MaternField& field, const Displacement& displacement,
    const SampleRequest& request, const std::vector<double*>& samples, const Progress& progress);

  /// Adds posterior mean and standard deviation as the settings say, after Condition().
  void AddPosterior(const Surface& surface, vtkDataSet* output, const Progress& progress);

private:
  struct Prepared
  {
    const MaternField* Field = nullptr;
    Displacement Directions;
    double Scale = 1.0;
    SparseRowMatrix Matrix;
    Eigen::VectorXd Deviations;
    std::unique_ptr<FieldConditioning> System;
    Eigen::MatrixXd Values;                  ///< of the last update
    Eigen::VectorXd Excluded;                ///< see DisplacementObservations, of the last update
    std::optional<Eigen::VectorXd> Variance; ///< of the posterior, once it was asked for
  };

  DisplacementObservations Observe(const Surface& surface, const Displacement& displacement, int components) const;
  Prepared& Prepare(const Surface& surface, const MaternField& field, const Displacement& displacement,
    const SampleRequest& request, const Progress& progress);
  std::string WarnOfExcluded(const Surface& surface, const Prepared& prepared);

  vtkSmartPointer<vtkPolyData> Given;
  ConditioningSettings Settings;
  BlockCache<Prepared> Blocks;
  std::int64_t Systems = 0;
  double UnreachedDistance = 0.0;
};

} // namespace surfsynth
