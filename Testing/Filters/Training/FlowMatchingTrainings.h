// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Small trainings that the tests of vtkFlowMatchingTrainer share.
#pragma once

#include "FileBytes.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkFlowMatchingTrainer.h"

#include "IO/Datasets/SignalDataset.h"

#include <vtkDataObject.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

class vtkTable;

namespace surfsynthtest
{

using Surfaces = std::vector<vtkSmartPointer<vtkPolyData>>;

/// A sphere stretched along z, with the point array Heat of two components.
vtkSmartPointer<vtkPolyData> Stretched(double stretch, int pointType = 11 /* VTK_DOUBLE */);

/// The samples of most tests are spheres with these stretches.
extern const std::vector<double> Stretches;
Surfaces Samples();

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const std::vector<vtkSmartPointer<vtkDataObject>>& leaves);
vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const Surfaces& surfaces);

/// Source of a dataset file with these surfaces of triangles; @p array "" for the positions.
surfsynth::SignalSource SourceOf(vtkPolyData* surface, const Surfaces& samples, const char* array = "");

vtkTable* TableOf(vtkAlgorithm* filter);

/// A folder of its own for the files of a test.
class FlowMatchingTrainerFilter : public ::testing::Test
{
protected:
  void SetUp() override;
  std::string File(const std::string& name) const { return (this->Folder / name).string(); }

  /// A training of less than a second that writes <name>.
  vtkSmartPointer<vtkFlowMatchingTrainer> Tiny(const std::string& name, int iterations = 5) const;
  /// The same on a sphere and on Samples().
  vtkSmartPointer<vtkFlowMatchingTrainer> OnBlocks(const std::string& name, int iterations = 5) const;

  /// The bytes of the model that a filter writes, in one execution without an error.
  std::string ModelBytes(vtkFlowMatchingTrainer* filter) const;
  /// The bytes of the model that a filter writes which is given @p dataset as a file.
  std::string DatasetBytes(
    const surfsynth::SignalDataset& dataset, const vtkSmartPointer<vtkFlowMatchingTrainer>& filter) const;

  /// One error with these parts in its text, an empty table and no file called refused.
  void ExpectRefusal(vtkFlowMatchingTrainer* filter, const std::vector<std::string>& parts) const;

  std::filesystem::path Folder;
};

} // namespace surfsynthtest
