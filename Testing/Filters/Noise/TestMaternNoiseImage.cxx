// SPDX-License-Identifier: BSD-3-Clause
//
// R19, the picture: one seed on a sphere, compared with Testing/Data/MaternNoise.png by vtkImageDifference.
//
// The file changes only when the noise is meant to change. To write it again, from the build folder:
//   SURFACE_SYNTHESIS_REGENERATE_BASELINES=1 xvfb-run -a bin/TestMaternNoiseImage
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkImageData.h>
#include <vtkImageDifference.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <gtest/gtest.h>

#include <cstdlib>

using namespace surfsynthtest;

namespace
{
const char* const BaselineFile = SURFSYNTH_TEST_DATA "/MaternNoise.png";

/// vtkImageDifference's thresholded error: what remains of the difference, in grey levels summed over the picture and
/// divided by 255, after shifts of a pixel and differences of up to 16 levels are forgiven. VTK's own tests use 10.
constexpr double Threshold = 10.0;

vtkSmartPointer<vtkImageData> Picture(int seed)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetInputDataObject(Icosphere(5).ToPolyData());
  filter->SetCorrelationRange(0.8);
  filter->SetSeed(seed);
  EXPECT_TRUE(Update(filter));
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(filter->GetOutputPort());
  mapper->SetScalarRange(-2.5, 2.5);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  renderer->SetBackground(1.0, 1.0, 1.0);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Zoom(1.4);
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->SetSize(200, 200);
  window->AddRenderer(renderer);
  window->Render();
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->ReadFrontBufferOff();
  grab->Update();
  return grab->GetOutput();
}

double Difference(vtkImageData* picture, vtkImageData* baseline)
{
  vtkNew<vtkImageDifference> difference;
  difference->SetInputData(picture);
  difference->SetImageData(baseline);
  difference->Update();
  return difference->GetThresholdedError();
}
} // namespace

TEST(MaternNoiseImage, ThePictureOfOneSeedIsThatOfTheFile)
{
  if (!std::getenv("DISPLAY"))
  {
    GTEST_SKIP() << "no display: run this under xvfb-run";
  }
  if (IsSanitized())
  {
    GTEST_SKIP() << "the graphics driver is not instrumented";
  }
  const auto picture = Picture(42);
  if (std::getenv("SURFACE_SYNTHESIS_REGENERATE_BASELINES"))
  {
    vtkNew<vtkPNGWriter> writer;
    writer->SetInputData(picture);
    writer->SetFileName(BaselineFile);
    writer->Write();
    GTEST_SKIP() << "wrote " << BaselineFile;
  }
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(BaselineFile);
  reader->Update();
  ASSERT_EQ(reader->GetOutput()->GetNumberOfPoints(), 200 * 200) << BaselineFile;
  EXPECT_LT(Difference(picture, reader->GetOutput()), Threshold);
  EXPECT_GT(Difference(Picture(43), reader->GetOutput()), 5.0 * Threshold) << "another seed must be told apart";
}
