// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Statistics of an ensemble, and the shape model in them, as arrays of surfaces and tables. Private to the module.
#pragma once

#include "EnsembleReading.h"
#include "TableColumns.h"

#include "Core/Statistics/EnsembleStatistics.h"

#include <Eigen/Core>

#include <array>
#include <string>
#include <vector>

class vtkPolyData;
class vtkTable;

namespace surfsynth
{

/// Names of arrays and fields of a surface with statistics.
constexpr const char* MeanName = "Mean";
constexpr const char* ModeName = "Mode";
constexpr const char* EnsembleArrayField = "EnsembleArrayName";

/// Parameters of the names of arrays.
struct StatisticsNames
{
  std::string Array;             ///< array of the samples; empty for positions
  std::vector<double> Quantiles; ///< probabilities
};

/// Fills @p surface with the cells of @p first, the mean and the arrays of statistics.
void FillStatisticsSurface(vtkPolyData* surface, vtkPolyData* first, const EnsembleStatistics& statistics,
  int components, const StatisticsNames& names);

/// Adds the field arrays: counts, standard deviations of the modes, name of the array.
void AddModelFields(
  vtkPolyData* surface, const EnsembleStatistics& statistics, vtkIdType samples, const StatisticsNames& names);

/// Fills a table with a row for each mode.
void FillModeTable(vtkTable* table, const EnsembleStatistics& statistics);

/// Fills a table with a row for each sample.
void FillSampleTable(vtkTable* table, const EnsembleStatistics& statistics, const Ensemble& ensemble);

/// Replaces the points of @p surface, float64, by [3 V] coordinates.
void SetPositions(vtkPolyData* surface, const Eigen::VectorXd& values);

/// Adds a point array, float64, of [C V] values; replaces one of the same name.
void AddValues(vtkPolyData* surface, const std::string& name, const Eigen::VectorXd& values, int components);

/// Appends a column of class @p Array with that name and one value.
template <typename Array, typename Value>
void AddValue(vtkTable* table, const char* name, Value value)
{
  AddColumn<Array>(table, name, std::array<Value, 1>{ value });
}

} // namespace surfsynth
