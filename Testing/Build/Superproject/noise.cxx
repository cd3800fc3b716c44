// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Samples Matérn noise on a sphere and checks that the output holds an array of plausible numbers.
#include <vtkDataArray.h>
#include <vtkMaternNoiseFilter.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSphereSource.h>

#include <cmath>
#include <iostream>

int main()
{
  vtkNew<vtkSphereSource> sphere;
  sphere->SetThetaResolution(40);
  sphere->SetPhiResolution(20);
  vtkNew<vtkMaternNoiseFilter> noise;
  noise->SetInputConnection(sphere->GetOutputPort());
  noise->SetCorrelationRange(0.3);
  noise->Update();

  vtkPolyData* output = vtkPolyData::SafeDownCast(noise->GetOutput());
  vtkDataArray* values = output ? output->GetPointData()->GetArray("MaternNoise") : nullptr;
  if (!values || values->GetNumberOfTuples() == 0 || values->GetNumberOfTuples() != output->GetNumberOfPoints())
  {
    std::cerr << "no array MaternNoise with one value for each point\n";
    return 1;
  }
  double sumOfSquares = 0.0;
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
  {
    sumOfSquares += values->GetTuple1(i) * values->GetTuple1(i);
  }
  // The field has standard deviation 1, and about 40 independent patches: far from these bounds.
  const double rms = std::sqrt(sumOfSquares / static_cast<double>(values->GetNumberOfTuples()));
  if (!(rms > 0.5 && rms < 2.0))
  {
    std::cerr << "root mean square " << rms << ", expected about 1\n";
    return 1;
  }
  std::cout << "root mean square " << rms << "\n";
  return 0;
}
