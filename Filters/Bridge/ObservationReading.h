// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Observations of fields at points, out of VTK's data objects.
#pragma once

#include "vtkSurfaceSynthesisBridgeModule.h" // For export macro

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Mesh/VolumePlace.h"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <Eigen/Core>

#include <string>
#include <vector>

class vtkInformation;
class vtkInformationVector;

namespace surfsynth
{

/// Observations of a field.
struct Observations
{
  PointMatrix Points;         ///< [n, 3], world units
  Eigen::MatrixXd Values;     ///< [n, C]
  Eigen::VectorXd Deviations; ///< [n], standard deviations of the values, at least 0
};

/// Names of the arrays of observations.
struct ObservationNames
{
  std::string
    Values; ///< of the property ObservationArray; "" for the active scalars, or the active vectors where these fit
  std::string Deviations; ///< of the property ObservationDeviationArray; "" for exact observations
};

/// Accepts an optional dataset with points (vtkPointSet) on the port; for FillInputPortInformation.
VTKSURFACESYNTHESISBRIDGE_EXPORT int AcceptObservations(vtkInformation* info);

/// Returns the points and point arrays of the dataset on a port; null when there is none.
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkPolyData> ObservationsHere(vtkInformationVector* port);

/// Does the same for a filter that works on several ranks. On several MPI ranks, every rank gets the
/// dataset of the one rank that has points. Collective.
/// @throws InvalidInput, on all ranks, when several ranks have points.
VTKSURFACESYNTHESISBRIDGE_EXPORT vtkSmartPointer<vtkPolyData> ObservationsOn(vtkInformationVector* port);

/// Reads the observations at the points of @p data.
/// @param components of the values
/// @throws InvalidInput when an array is missing (the text lists those that are there), has another number of
/// components or is not finite, or a deviation is negative: the text names the array and the first point.
VTKSURFACESYNTHESISBRIDGE_EXPORT Observations ReadObservations(
  vtkPolyData* data, const ObservationNames& names, int components);

/// Reads fields at the points of @p data: the components of the point array @p name, or of the arrays <name>_0,
/// <name>_1 and so on when there is none of that name; "" for the active scalars.
/// @param property that names the array, for messages
/// @return [points, fields]
/// @throws InvalidInput when there is no such array, or a value at one of the points @p used is not finite.
VTKSURFACESYNTHESISBRIDGE_EXPORT Eigen::MatrixXd ReadFields(
  vtkPolyData* data, const std::string& name, const std::string& property, const std::vector<Index>& used);

/// Finds the nearest places of the surface to each point.
/// @param tolerance largest distance from the surface, world units; 0 for a hundredth of the longest side of the box
/// @throws InvalidInput when points are farther away: the text names the first ten with the first one's distance.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<SurfacePlace> AttachToSurface(
  const TriangleMesh& mesh, const PointMatrix& points, double tolerance);

/// Does the same in a volume: points inside attach to the tetrahedron that contains them, points outside to the nearest
/// place of the boundary.
VTKSURFACESYNTHESISBRIDGE_EXPORT std::vector<VolumePlace> AttachToVolume(
  const TetrahedralMesh& mesh, const PointMatrix& points, double tolerance);

} // namespace surfsynth
