// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a network says about a surface, as VTK's arrays.
#pragma once

#include "Core/Mesh/UsedPoints.h"
#include "Inference/PoissonNet/PoissonNetEvaluator.h"

#include <string>

class vtkPolyData;

namespace surfsynth
{

struct Surface;

/// The names of the arrays, which are properties of the filter.
struct PredictionNames
{
  std::string Prediction;
  std::string Label;
  std::string ClassNames;
  std::string Displacement;
};

/// What was evaluated on a surface.
struct EvaluatedSurface
{
  const Surface& Input;
  const UsedPoints& Points;
  const PoissonNetModel& Model;
  const MeshNormalisation& Normalisation;
};

/// Adds @p prediction to @p output, a copy of the surface that was evaluated: point, cell or field data as its domain
/// says, labels and class names of a classifier, the displacement of a gradient-domain head. The header of
/// vtkPoissonNetFilter describes the arrays.
void AddPredictionArrays(const EvaluatedSurface& evaluated, const PoissonNetPrediction& prediction,
  const PredictionNames& names, vtkPolyData* output);

} // namespace surfsynth
