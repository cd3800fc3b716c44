// SPDX-License-Identifier: BSD-3-Clause
#include "PredictionArrays.h"

#include "NewArray.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"

#include "Core/Operators/SurfaceOperators.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surfsynth
{

namespace
{
/// Label of points and cells that are no input of the network.
constexpr int NoLabel = -1;

/// Destination of the values of a domain: a tuple of the output for each row; some tuples have no row.
struct Rows
{
  FeatureMatrix Values;
  std::vector<vtkIdType> Tuples; ///< [rows]
  vtkIdType Count = 0;           ///< tuples of the output
};

Rows PointRows(const EvaluatedSurface& evaluated, const FeatureMatrix& values)
{
  Rows rows{ values, std::vector<vtkIdType>(static_cast<std::size_t>(values.rows())),
    evaluated.Input.Mesh.NumberOfPoints() };
  for (Index k = 0; k < evaluated.Points.Count(); ++k)
  {
    rows.Tuples[static_cast<std::size_t>(k)] = evaluated.Points.Id(k);
  }
  return rows;
}

/// Averages the values of the triangles of each cell, weighted by area. For a classifier that is the mean of the
/// logits, up to a constant that the new normalisation removes, as the network averages the corners of a triangle.
Rows CellRows(const EvaluatedSurface& evaluated, const FeatureMatrix& values, vtkIdType cells)
{
  const Surface& surface = evaluated.Input;
  Rows rows;
  rows.Count = cells;
  std::vector<Eigen::Index> rowOfCell(static_cast<std::size_t>(cells), -1);
  for (Index f = 0; f < surface.Mesh.NumberOfTriangles(); ++f)
  {
    Eigen::Index& row = rowOfCell[static_cast<std::size_t>(surface.Cell(f))];
    if (row < 0)
    {
      row = static_cast<Eigen::Index>(rows.Tuples.size());
      rows.Tuples.push_back(surface.Cell(f));
    }
  }
  if (rows.Tuples.size() == static_cast<std::size_t>(values.rows()))
  {
    rows.Values = values; // a triangle for each cell, in the same order
    return rows;
  }
  const Eigen::VectorXd areas = FaceAreas(surface.Mesh);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.Tuples.size()), values.cols());
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(sums.rows());
  for (Index f = 0; f < surface.Mesh.NumberOfTriangles(); ++f)
  {
    const Eigen::Index row = rowOfCell[static_cast<std::size_t>(surface.Cell(f))];
    sums.row(row) += areas[f] * values.row(f).cast<double>();
    weights[row] += areas[f];
  }
  sums = weights.cwiseInverse().asDiagonal() * sums;
  if (evaluated.Model.IsClassifier())
  {
    const Eigen::VectorXd largest = sums.rowwise().maxCoeff();
    const Eigen::MatrixXd shifted = sums.colwise() - largest;
    sums = shifted.colwise() - shifted.array().exp().rowwise().sum().log().matrix();
  }
  rows.Values = sums.cast<float>();
  return rows;
}

/// Returns the values for the whole surface: one tuple of field data.
Rows GlobalRows(const FeatureMatrix& values) { return { values, { 0 }, 1 }; }

vtkSmartPointer<vtkDataArray> ValueArray(const Rows& rows, const std::string& name, const PoissonNetModel& model)
{
  const auto components = static_cast<int>(rows.Values.cols());
  const auto array = NewArray<vtkFloatArray>(name, rows.Count, components);
  for (std::size_t k = 0; k < rows.Tuples.size(); ++k)
  {
    std::copy_n(
      rows.Values.row(static_cast<Eigen::Index>(k)).data(), components, array->GetPointer(rows.Tuples[k] * components));
  }
  for (std::size_t c = 0; c < model.Classes.size(); ++c)
  {
    array->SetComponentName(static_cast<vtkIdType>(c), model.Classes[c].c_str());
  }
  return array;
}

vtkSmartPointer<vtkDataArray> LabelArray(const Rows& rows, const std::string& name)
{
  PoissonNetPrediction prediction;
  prediction.Values = rows.Values;
  const std::vector<Index> labels = prediction.Labels();
  const auto array = NewArray<vtkIntArray>(name, rows.Count, 1);
  array->FillValue(NoLabel);
  for (std::size_t k = 0; k < rows.Tuples.size(); ++k)
  {
    array->SetValue(rows.Tuples[k], static_cast<int>(labels[k]));
  }
  return array;
}

/// Computes the centroid of the surface when its points are at @p points.
Eigen::RowVector3d Centroid(const TriangleMesh& mesh, const Eigen::VectorXd& areas, const PointMatrix& points)
{
  Eigen::RowVector3d moment = Eigen::RowVector3d::Zero();
  for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      moment += areas[f] / 3.0 * points.row(mesh.Triangles(f, k));
    }
  }
  return moment / areas.sum();
}

/// Adds predicted positions in the caller's coordinates, and the displacement to them that keeps the centroid.
void AddPositions(
  const EvaluatedSurface& evaluated, const FeatureMatrix& values, const PredictionNames& names, vtkPolyData* output)
{
  const TriangleMesh& mesh = evaluated.Input.Mesh;
  PointMatrix predicted = mesh.Points;
  for (Index k = 0; k < evaluated.Points.Count(); ++k)
  {
    predicted.row(evaluated.Points.Id(k)) = values.row(k).cast<double>() * evaluated.Normalization.Scale +
      evaluated.Normalization.Center;
  }
  const Eigen::VectorXd areas = FaceAreas(mesh);
  const Eigen::RowVector3d shift = Centroid(mesh, areas, mesh.Points) - Centroid(mesh, areas, predicted);
  const auto positions = NewArray<vtkDoubleArray>(names.Prediction, mesh.NumberOfPoints(), 3);
  const auto displacement = NewArray<vtkDoubleArray>(names.Displacement, mesh.NumberOfPoints(), 3);
  for (Index k = 0; k < evaluated.Points.Count(); ++k)
  {
    const Index v = evaluated.Points.Id(k);
    for (int c = 0; c < 3; ++c)
    {
      positions->SetTypedComponent(v, c, predicted(v, c));
      displacement->SetTypedComponent(v, c, predicted(v, c) + shift(c) - mesh.Points(v, c));
    }
  }
  output->GetPointData()->AddArray(positions);
  output->GetPointData()->AddArray(displacement);
  if (!output->GetPointData()->GetVectors())
  {
    output->GetPointData()->SetActiveVectors(names.Displacement.c_str());
  }
}

void AddClassNames(const PoissonNetModel& model, const std::string& name, vtkPolyData* output)
{
  vtkNew<vtkStringArray> classes;
  classes->SetName(name.c_str());
  for (const std::string& text : model.Classes)
  {
    classes->InsertNextValue(text);
  }
  output->GetFieldData()->AddArray(classes);
}
} // namespace

void AddPredictionArrays(const EvaluatedSurface& evaluated, const PoissonNetPrediction& prediction,
  const PredictionNames& names, vtkPolyData* output)
{
  const PoissonNetModel& model = evaluated.Model;
  if (model.Options.Head == PoissonNetHead::GradientDomain)
  {
    AddPositions(evaluated, prediction.Values, names, output);
    return;
  }
  const bool atPoints = prediction.Domain == PoissonNetDomain::Vertices;
  const bool atCells = prediction.Domain == PoissonNetDomain::Faces;
  const Rows rows = atPoints ? PointRows(evaluated, prediction.Values)
    : atCells                ? CellRows(evaluated, prediction.Values, output->GetNumberOfCells())
                             : GlobalRows(prediction.Values);
  vtkDataSetAttributes* attributes = atPoints ? static_cast<vtkDataSetAttributes*>(output->GetPointData())
                                              : static_cast<vtkDataSetAttributes*>(output->GetCellData());
  vtkFieldData* target = atPoints || atCells ? attributes : output->GetFieldData();
  const bool isClassifier = model.IsClassifier() || !model.Classes.empty();
  target->AddArray(ValueArray(rows, names.Prediction, model));
  if (isClassifier)
  {
    target->AddArray(LabelArray(rows, names.Label));
  }
  if (!model.Classes.empty())
  {
    AddClassNames(model, names.ClassNames, output);
  }
  if (atPoints || atCells)
  {
    SetActiveWhereNone(attributes, (isClassifier ? names.Label : names.Prediction).c_str());
  }
}

} // namespace surfsynth
