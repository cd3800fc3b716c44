// SPDX-License-Identifier: BSD-3-Clause
#include "Reporting.h"

#include <gtest/gtest.h>

using surfsynth::InWordsOfParaView;

TEST(WordsOfParaView, FiltersAndPropertiesHaveTheLabelsOfMenuAndPanel)
{
  EXPECT_EQ(InWordsOfParaView("ModelFileName is empty; vtkFlowMatchingTrainer writes model files."),
    "Model File Name is empty; Flow Matching Trainer writes model files.");
  EXPECT_EQ(
    InWordsOfParaView("; vtkSurfaceRepairFilter with HoleFilling ALL_HOLES, or vtkFillHolesFilter, closes them."),
    "; Surface Repair with Hole Filling All Holes, or VDB Surface, closes them.");
  EXPECT_EQ(InWordsOfParaView("vtkSurfaceRepairFilter with KeepLargestComponentOn(), or vtkPolyDataConnectivityFilter"),
    "Surface Repair with Keep Largest Component, or Connectivity");
  EXPECT_EQ(InWordsOfParaView("Block 3: A vtkUnstructuredGrid was found where a vtkPolyData is needed"),
    "Block 3: An Unstructured Grid was found where a Polygonal Mesh is needed");
  EXPECT_EQ(InWordsOfParaView("There is no template on port 1, which Template GIVEN needs"),
    "There is no template as second input, which Template Given needs");
}

TEST(WordsOfParaView, NamesOfLibrariesAndOfTheUserStay)
{
  for (const char* text :
    { "PoissonNet, TetGen and LibTorch on 2 MPI ranks (CUDA)", "Cannot read models/VoxelSize/MyModel",
      "Cannot read \"My VoxelSize.vtp\"", "ModelFileName.safetensors", "'VoxelSize'", "x/VoxelSize", "" })
  {
    EXPECT_EQ(InWordsOfParaView(text), text);
  }
}
