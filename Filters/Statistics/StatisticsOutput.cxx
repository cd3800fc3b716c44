// SPDX-License-Identifier: BSD-3-Clause
#include "StatisticsOutput.h"

#include "NewArray.h"
#include "TableColumns.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <algorithm>
#include <charconv>

namespace surfsynth
{

namespace
{
vtkSmartPointer<vtkDoubleArray> ArrayOf(const std::string& name, const Eigen::VectorXd& values, int components)
{
  auto array = NewArray<vtkDoubleArray>(name, values.size() / components, components);
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  return array;
}

/// Shortest text that reads back as the same number: names of arrays with different numbers differ.
std::string ShortestNumber(double value)
{
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  return { text, end };
}

void AddDistance(vtkPolyData* surface, const Eigen::VectorXd& deviation, int components)
{
  const Eigen::Map<const Eigen::MatrixXd> rows(deviation.data(), components, deviation.size() / components);
  AddValues(surface, "StandardDistance", rows.colwise().norm().transpose(), 1);
}
} // namespace

void SetPositions(vtkPolyData* surface, const Eigen::VectorXd& values)
{
  vtkNew<vtkPoints> points;
  points->SetData(ArrayOf("Points", values, 3));
  surface->SetPoints(points);
}

void AddValues(vtkPolyData* surface, const std::string& name, const Eigen::VectorXd& values, int components)
{
  surface->GetPointData()->AddArray(ArrayOf(name, values, components));
}

void FillStatisticsSurface(vtkPolyData* surface, vtkPolyData* first, const EnsembleStatistics& statistics,
  int components, const StatisticsNames& names)
{
  surface->CopyStructure(first);
  surface->GetCellData()->PassData(first->GetCellData());
  if (names.Array.empty())
  {
    SetPositions(surface, statistics.Mean);
  }
  else
  {
    AddValues(surface, MeanName, statistics.Mean, components);
  }
  AddValues(surface, "StandardDeviation", statistics.StandardDeviation, components);
  if (components > 1)
  {
    AddDistance(surface, statistics.StandardDeviation, components);
  }
  for (std::size_t q = 0; q < names.Quantiles.size(); ++q)
  {
    AddValues(surface, "Quantile_" + ShortestNumber(names.Quantiles[q]),
      statistics.Quantiles.col(static_cast<Eigen::Index>(q)), components);
  }
  for (Eigen::Index k = 0; k < statistics.Modes.cols(); ++k)
  {
    AddValues(surface, std::string(ModeName) + "_" + std::to_string(k), statistics.Modes.col(k), components);
  }
  surface->GetPointData()->SetActiveScalars(components > 1 ? "StandardDistance" : "StandardDeviation");
}

void AddModelFields(
  vtkPolyData* surface, const EnsembleStatistics& statistics, vtkIdType samples, const StatisticsNames& names)
{
  vtkFieldData* fields = surface->GetFieldData();
  auto count = NewArray<vtkIdTypeArray>("NumberOfSamples", 1, 1);
  count->SetValue(0, samples);
  fields->AddArray(count);
  if (statistics.Modes.cols() > 0)
  {
    fields->AddArray(ArrayOf("ModeStandardDeviations", statistics.Variances.cwiseSqrt(), 1));
    fields->AddArray(ArrayOf("TotalVariance", Eigen::VectorXd::Constant(1, statistics.TotalVariance), 1));
  }
  vtkNew<vtkStringArray> name;
  name->SetName(EnsembleArrayField);
  name->InsertNextValue(names.Array);
  fields->AddArray(name);
}

void FillModeTable(vtkTable* table, const EnsembleStatistics& statistics)
{
  const Eigen::VectorXd& variances = statistics.Variances;
  std::vector<vtkIdType> modes;
  std::vector<double> fractions, cumulative;
  double sum = 0.0;
  for (Eigen::Index k = 0; k < variances.size(); ++k)
  {
    modes.push_back(k);
    sum += variances[k];
    fractions.push_back(variances[k] / statistics.TotalVariance);
    cumulative.push_back(sum / statistics.TotalVariance);
  }
  AddColumn<vtkIdTypeArray>(table, "Mode", modes);
  AddColumn<vtkDoubleArray>(table, "Variance", variances);
  AddColumn<vtkDoubleArray>(table, "StandardDeviation", variances.cwiseSqrt().eval());
  AddColumn<vtkDoubleArray>(table, "Fraction", fractions);
  AddColumn<vtkDoubleArray>(table, "CumulativeFraction", cumulative);
}

void FillSampleTable(vtkTable* table, const EnsembleStatistics& statistics, const Ensemble& ensemble)
{
  std::vector<vtkIdType> samples;
  std::vector<std::string> names;
  for (const EnsembleSample& sample : ensemble.Samples)
  {
    samples.push_back(static_cast<vtkIdType>(samples.size()));
    names.push_back(sample.Name);
  }
  AddColumn<vtkIdTypeArray>(table, "Sample", samples);
  AddColumn<vtkStringArray>(table, "SampleName", names);
  for (Eigen::Index k = 0; k < statistics.Coefficients.cols(); ++k)
  {
    const std::string name = "Coefficient_" + std::to_string(k);
    AddColumn<vtkDoubleArray>(table, name.c_str(), statistics.Coefficients.col(k).eval());
  }
}

} // namespace surfsynth
