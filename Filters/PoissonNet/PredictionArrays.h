// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Predictions of a network on a surface, as VTK's arrays.
#pragma once

#include "Core/Mesh/UsedPoints.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <string>

class vtkPolyData;

namespace surfsynth
{

struct Surface;

/// Names of the arrays, which are properties of the filter.
struct PredictionNames
{
  std::string Prediction;
  std::string Label;
  std::string ClassNames;
  std::string Displacement;
};

/// A surface and the model that was evaluated on it.
struct EvaluatedSurface
{
  const Surface& Input;
  const UsedPoints& Points;
  const PoissonNetModel& Model;
  const MeshNormalization& Normalization;
};

/// Adds @p prediction to @p output, a copy of the surface that was evaluated: point, cell or field data by its
/// domain, labels and class names of a classifier, the displacement of a gradient-domain head. The header of
/// vtkPoissonNetFilter describes the arrays.
void AddPredictionArrays(const EvaluatedSurface& evaluated, const PoissonNetPrediction& prediction,
  const PredictionNames& names, vtkPolyData* output);

} // namespace surfsynth
