// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Random displacements of surfaces, made of scalar random fields.
#pragma once

#include "Core/Mesh/SurfacePlace.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Core/Operators/SurfaceOperators.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace surfsynth
{

/// Directions in which the points of a surface are displaced. n is the unit vertex normal, the area-weighted mean of the
/// face normals, and f, f1, f2, f3 are independent scalar fields.
enum class DisplacementDirections
{
  Free,      ///< (f1, f2, f3)
  Normal,    ///< f n
  Tangential ///< (I - n n^T) (f1, f2, f3)
};

/// Observations of displacements as FieldConditioning takes them. The unknowns are V values in three columns for Free, the
/// V values of f for Normal, and the 3 V components, those of a vertex side by side, for Tangential.
struct DisplacementObservations
{
  SparseRowMatrix Matrix;     ///< [m, unknowns]: m = n, or 2 n for Tangential
  Eigen::MatrixXd Values;     ///< [m, 3] for Free, else [m, 1]
  Eigen::VectorXd Deviations; ///< [m]
  /// [n], world units: length of the part of each observed displacement that the directions exclude; it is left out.
  Eigen::VectorXd Excluded;
};

/// Displacements of one surface. When the fields have the standard deviation s at a vertex, the displacement has the
/// standard deviation s along the normal (Normal), along every tangent direction (Tangential), or along every direction
/// (Free), exactly, and none along the others.
class SurfaceDisplacement
{
public:
  /// @param normals n, [V, 3], unit; unused for Free, and may then be empty
  /// @throws InvalidInput when @p normals has another number of rows than V.
  SurfaceDisplacement(DisplacementDirections directions, Index numberOfPoints, PointMatrix normals);

  /// Directions of the displacement.
  DisplacementDirections Directions() const { return this->Kind; }
  /// Number of scalar fields: 1 for Normal, else 3.
  int NumberOfFields() const { return this->Kind == DisplacementDirections::Normal ? 1 : 3; }

  /// Replaces fields by displacements.
  /// @param values 3 V numbers: at first the fields, the NumberOfFields() values of a vertex side by side, in front; in
  /// the end [V, 3]. Displacements of Tangential and Free stay the same.
  void ToDisplacements(double* values) const;

  /// Returns the product with the covariance of the unknowns of DisplacementObservations, which uses this object.
  /// @param covariance product with the covariance of a scalar field, C x for [V, K]
  using Product = std::function<Eigen::MatrixXd(const Eigen::Ref<const Eigen::MatrixXd>&)>;
  Product Covariance(Product covariance) const;

  /// Returns the observations of displacements at places. Those of Normal are the parts along the normal that is
  /// interpolated at the place, those of Tangential two parts across it.
  /// @param displacements [n, 3], world units
  /// @param deviations [n], standard deviations of every component, world units
  /// @throws InvalidInput when numbers of rows differ, or a place has no triangle of @p mesh.
  DisplacementObservations Observe(const TriangleMesh& mesh, const std::vector<SurfacePlace>& places,
    const Eigen::MatrixXd& displacements, const Eigen::VectorXd& deviations) const;

  /// Returns the variances of the unknowns of DisplacementObservations from those of the scalar fields, [V].
  Eigen::VectorXd UnknownVariances(const Eigen::VectorXd& variances) const;

  /// Standard deviation along the directions, [V]: along the normal (Normal), or the root mean square over the tangent
  /// directions (Tangential) or all directions (Free).
  /// @param variances of the unknowns of DisplacementObservations
  Eigen::VectorXd DeviationAlong(const Eigen::VectorXd& variances) const;

private:
  DisplacementDirections Kind;
  Index Points;
  PointMatrix Normals;
};

/// Triangles that a displacement inverts.
struct InvertedTriangles
{
  Index Count = 0;  ///< number of them
  Index First = -1; ///< the first one; -1 for none
};

/// Finds the triangles whose normal after the displacement is not within 90 degrees of that before, or which have no area
/// after it: where a surface folds, or turns by a right angle.
/// @param displacements [V, 3], the components of a vertex side by side, world units
InvertedTriangles FindInvertedTriangles(const TriangleMesh& mesh, const double* displacements);

} // namespace surfsynth
