// SPDX-License-Identifier: BSD-3-Clause
//
// From a scan to tetrahedra, as one VTK pipeline:
//
//   MedicalPipeline <volume.nii[.gz]> <output> [points [voxel size]]
//
// reads a NIfTI volume, makes its surface with vtkVDBSurfaceFilter, puts it into the scan's coordinates, remeshes it to
// about so many points (default 20000), adds a random field with a range of 20 mm, fills it with tetrahedra, and writes
// <output>.vtp and <output>.vtu. The voxel size of the level set is in millimetres (default: the scan's own).
#include "vtkIsotropicRemeshFilter.h"
#include "vtkMaternNoiseFilter.h"
#include "vtkSurfaceRepairFilter.h"
#include "vtkTetrahedralizeFilter.h"
#include "vtkVDBSurfaceFilter.h"

#include <vtkDataSet.h>
#include <vtkMatrix4x4.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNew.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

namespace
{
/// Brings a filter up to date and says what it made; VTK prints errors itself.
void Run(vtkAlgorithm* filter, const char* what)
{
  filter->Update();
  auto* made = vtkDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  if (!made || made->GetNumberOfPoints() == 0)
  {
    throw std::runtime_error(std::string("no ") + what);
  }
  std::cout << what << ": " << made->GetNumberOfPoints() << " points, " << made->GetNumberOfCells() << " cells\n";
}

/// From the coordinates of the image to those of the scan: the matrix of the sform, else of the qform.
vtkSmartPointer<vtkTransform> ScanCoordinates(vtkNIFTIImageReader* reader)
{
  auto transform = vtkSmartPointer<vtkTransform>::New();
  vtkMatrix4x4* matrix = reader->GetSFormMatrix() ? reader->GetSFormMatrix() : reader->GetQFormMatrix();
  if (matrix)
  {
    transform->SetMatrix(matrix);
  }
  return transform;
}

template <typename Writer>
void Write(vtkAlgorithm* source, const std::string& path)
{
  vtkNew<Writer> writer;
  writer->SetInputConnection(source->GetOutputPort());
  writer->SetFileName(path.c_str());
  if (!writer->Write())
  {
    throw std::runtime_error("cannot write " + path);
  }
}

void Process(const std::string& volume, const std::string& output, int points, double voxelSize)
{
  vtkNew<vtkNIFTIImageReader> reader;
  if (!reader->CanReadFile(volume.c_str()))
  {
    throw std::runtime_error("cannot read " + volume);
  }
  reader->SetFileName(volume.c_str());

  vtkNew<vtkVDBSurfaceFilter> surface;
  surface->SetInputConnection(reader->GetOutputPort());
  surface->SetVoxelSize(voxelSize);
  surface->SetSmoothingToMeanCurvature();
  surface->SetSmoothingIterations(2);
  surface->SetClosing(2.0);
  surface->FillCavitiesOn();
  surface->LargestComponentOn();
  Run(surface, "surface");

  vtkNew<vtkTransformPolyDataFilter> placed;
  placed->SetInputConnection(surface->GetOutputPort());
  placed->SetTransform(ScanCoordinates(reader));
  vtkNew<vtkSurfaceRepairFilter> repaired; // a flip in the scan's matrix turns the surface inside out
  repaired->SetInputConnection(placed->GetOutputPort());
  Run(repaired, "in the scan's coordinates");

  vtkNew<vtkIsotropicRemeshFilter> even;
  even->SetInputConnection(repaired->GetOutputPort());
  even->SetTargetNumberOfPoints(points);
  even->KeepFeatureEdgesOff();
  Run(even, "remeshed");

  vtkNew<vtkMaternNoiseFilter> noise;
  noise->SetInputConnection(even->GetOutputPort());
  noise->SetCorrelationRange(20.0);
  Run(noise, "random field");

  vtkNew<vtkTetrahedralizeFilter> solid;
  solid->SetInputConnection(noise->GetOutputPort());
  Run(solid, "tetrahedra");

  Write<vtkXMLPolyDataWriter>(noise, output + ".vtp");
  Write<vtkXMLUnstructuredGridWriter>(solid, output + ".vtu");
}
} // namespace

int main(int argc, char* argv[])
{
  if (argc < 3 || argc > 5)
  {
    std::cerr << "usage: MedicalPipeline <volume.nii[.gz]> <output> [points [voxel size]]\n";
    return EXIT_FAILURE;
  }
  try
  {
    Process(argv[1], argv[2], argc > 3 ? std::stoi(argv[3]) : 20000, argc > 4 ? std::stod(argv[4]) : 0.0);
  }
  catch (const std::exception& error)
  {
    std::cerr << "MedicalPipeline: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
