// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Adds Matérn noise to a surface, from file to file:
///
///   MaternNoise [input.stl|.ply|.vtp] output.vtp [--range R] [--samples N] [--seed S]
///
/// Without an input, a sphere of radius 1 is used. Prints the scale that was used and the statistics of the noise.

#include "vtkMaternNoiseFilter.h"

#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataAlgorithm.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>

#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{
struct Arguments
{
  std::string Input; // empty: a sphere
  std::string Output;
  double Range = 0.0; // 0: the filter's default
  int Samples = 1;
  int Seed = 0;
};

Arguments Parse(int argc, char* argv[])
{
  Arguments arguments;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i)
  {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0)
    {
      files.push_back(word);
      continue;
    }
    if (++i == argc)
    {
      throw std::invalid_argument(word + " needs a value");
    }
    if (word == "--range")
    {
      arguments.Range = std::stod(argv[i]);
    }
    else if (word == "--samples")
    {
      arguments.Samples = std::stoi(argv[i]);
    }
    else if (word == "--seed")
    {
      arguments.Seed = std::stoi(argv[i]);
    }
    else
    {
      throw std::invalid_argument("unknown option " + word);
    }
  }
  if (files.empty() || files.size() > 2)
  {
    throw std::invalid_argument(
      "usage: MaternNoise [input.stl|.ply|.vtp] output.vtp [--range R] [--samples N] [--seed S]");
  }
  arguments.Output = files.back();
  arguments.Input = files.size() == 2 ? files.front() : std::string();
  return arguments;
}

bool EndsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

template <typename Reader>
vtkSmartPointer<vtkPolyDataAlgorithm> NewReader(const std::string& name)
{
  auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(name.c_str());
  return reader;
}

/// The reader for a file, or a sphere.
vtkSmartPointer<vtkAlgorithm> NewSource(const std::string& name)
{
  if (name.empty())
  {
    auto sphere = vtkSmartPointer<vtkSphereSource>::New();
    sphere->SetRadius(1.0);
    sphere->SetThetaResolution(100);
    sphere->SetPhiResolution(100);
    return sphere;
  }
  if (EndsWith(name, ".stl"))
  {
    return NewReader<vtkSTLReader>(name);
  }
  if (EndsWith(name, ".ply"))
  {
    return NewReader<vtkPLYReader>(name);
  }
  auto reader = vtkSmartPointer<vtkXMLPolyDataReader>::New();
  reader->SetFileName(name.c_str());
  return reader;
}

/// Mean and standard deviation over all values of the arrays that the filter has added.
void PrintStatistics(vtkMaternNoiseFilter* filter)
{
  vtkPointData* data = vtkPolyData::SafeDownCast(filter->GetOutput())->GetPointData();
  const std::string name = filter->GetOutputArrayName();
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (int sample = 0; sample < filter->GetNumberOfSamples(); ++sample)
  {
    vtkDataArray* values = data->GetArray(
      filter->GetNumberOfSamples() == 1 ? name.c_str() : (name + "_" + std::to_string(sample)).c_str());
    for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
    {
      const double value = values->GetTuple1(i);
      sum += value;
      squares += value * value;
      count += 1.0;
    }
  }
  const double mean = sum / count;
  std::cout << "tau " << filter->GetEffectiveScreening() << ", range " << filter->GetEffectiveCorrelationRange()
            << ", largest residual " << filter->GetRelativeResidual() << '\n'
            << "mean " << mean << ", standard deviation " << std::sqrt(squares / count - mean * mean) << '\n';
}
} // namespace

int main(int argc, char* argv[])
{
  try
  {
    const Arguments arguments = Parse(argc, argv);
    const auto source = NewSource(arguments.Input);

    vtkNew<vtkMaternNoiseFilter> noise;
    noise->SetInputConnection(source->GetOutputPort());
    noise->SetCorrelationRange(arguments.Range);
    noise->SetNumberOfSamples(arguments.Samples);
    noise->SetSeed(arguments.Seed);
    noise->Update(); // errors go to VTK's output window
    if (!vtkPolyData::SafeDownCast(noise->GetOutput()) ||
      noise->GetOutput()->GetNumberOfElements(vtkDataObject::POINT) == 0)
    {
      throw std::runtime_error("no noise was made");
    }
    PrintStatistics(noise);

    vtkNew<vtkXMLPolyDataWriter> writer;
    writer->SetFileName(arguments.Output.c_str());
    writer->SetInputConnection(noise->GetOutputPort());
    if (!writer->Write())
    {
      throw std::runtime_error("cannot write " + arguments.Output);
    }
  }
  catch (const std::exception& error)
  {
    std::cerr << "MaternNoise: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
