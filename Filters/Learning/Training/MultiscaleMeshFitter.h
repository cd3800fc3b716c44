// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A surface as meshes at several scales, for the training of geometric textures. This header needs no torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "IO/Datasets/MultiscaleDataset.h"

#include <cstdint>
#include <vector>

namespace surfsynth
{

/// The mesh that is fitted to the reference: of the reference's topology, and wound as it is.
enum class FitTemplate
{
  Icosphere,
  Torus,  ///< around the z axis, radii 1 and 0.4
  Given,  ///< a mesh of the caller
  Surface ///< the reference itself, smoothed and simplified; any topology, with or without boundary
};

/// The recipe.
struct MultiscaleFitOptions
{
  std::int64_t Levels = 5; ///< 1 to 10
  FitTemplate Template = FitTemplate::Icosphere;
  std::int64_t IcosphereLevel = 2;      ///< 0 to 6: 20 4^level triangles
  std::int64_t TorusSegments = 24;      ///< 3 to 1000, around the axis; a third as many around the tube, at least 3
  TriangleMesh GivenTemplate;           ///< of FitTemplate::Given
  std::int64_t TemplateTriangles = 320; ///< wanted for FitTemplate::Surface, 4 to 1e6
  /// For FitTemplate::Surface, of SmoothedForm(), >= 0; 0: half the template's mean edge length.
  double SmoothingLength = 0.0;
  std::int64_t Iterations = 300;       ///< of each level, >= 0; for FitTemplate::Surface rounds of relaxation
  std::int64_t TriangulationSteps = 3; ///< of the optimiser in each iteration, 0 to 1000
  std::int64_t ChamferSteps = 2;       ///< after those, 0 to 1000
  double LearningRate = 1e-2;          ///< of Adam, in mean edge lengths of the template, halved with each level; > 0
  double LearningRateDecay = 0.1;      ///< the rate of a level's last iteration over that of its first, above 0 to 1
  std::int64_t Samples = 3000;         ///< on each surface at level 0, (l + 1) times as many at level l; 1 to 1e6
  bool PublishedNormals = false; ///< see ComputeChamferLoss(): unrelated normals are compared, as in the published code
  std::uint64_t Seed = 0;
  /// Minutes of the whole fit, >= 0; 0: no limit. A level may use (level + 1) parts of what is left of it, as it has as many
  /// samples; its learning rate falls over that time where it ends before the iterations.
  double TimeBudget = 0.0;
};

/// Checks the recipe. @throws InvalidInput naming the first option that is out of its range.
void CheckOptions(const MultiscaleFitOptions& options);

/// Distances of a level from the reference.
struct FitDistance
{
  double Mean = 0.0;                  ///< of the vertices of the level from the reference, its units
  double Largest = 0.0;               ///< of these vertices
  double SymmetricMean = 0.0;         ///< of 20,000 samples on each surface from the other one, its units
  double SymmetricPercentile95 = 0.0; ///< of these samples
  double NormalAngle = 0.0;           ///< mean angle of the normals at such samples, degrees; see MeanNormalAngle()
};

/// The result.
struct MultiscaleFit
{
  /// The levels, and the template as the fit began with it; in the coordinates of the reference.
  MultiscaleDataset Dataset;
  std::vector<FitDistance> Distances; ///< of each level
  /// Number of iterations done at each level: fewer than asked for where the time budget has ended it.
  std::vector<std::int64_t> Iterations;
  double SecondsForAll = 0.0; ///< estimated for all iterations of all levels; 0 when none was done
};

/// Fits a template to @p reference, subdivides it at midpoints, fits it again, and so on: section 4 of "Deep Geometric
/// Texture Synthesis" (Hertz et al. 2020). Both meshes are first moved to the centre of their boxes and divided by half of
/// the longest side. Each iteration takes steps that keep triangles even, and steps that bring random samples of both
/// surfaces closer; see MeshFitLosses.h. Everything random is a pure function of (seed, level, iteration, step).
///
/// FitTemplate::Surface fits without losses: the simplification maps the template onto the reference one to one (see
/// SurfaceSimplification), the points of the finest level are placed by that map, relaxed along the reference, points of the
/// boundary along its boundary, and smoothed where triangles fold. Coarser levels have the points that they share with the
/// finest one. Learning rates, steps, samples and the seed play no part.
///
/// @param reference finite triangles with area; need not be manifold or closed, but manifold and wound alike for
/// FitTemplate::Surface
/// @throws InvalidInput when an option is out of range, the reference is broken or the template does not meet
/// GeometricTextureSampler::Requirements(); SolverFailure when a loss is not finite, or the topology of a template made from
/// the reference differs; Cancelled.
MultiscaleFit FitMultiscaleMesh(
  const TriangleMesh& reference, const MultiscaleFitOptions& options, const Progress& progress = {});

} // namespace surfsynth
