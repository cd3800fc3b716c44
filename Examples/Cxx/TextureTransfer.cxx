// SPDX-License-Identifier: BSD-3-Clause
//
// A texture on another triangulation of its surface, as one VTK pipeline:
//
//   TextureTransfer <model> <surface.obj> <texture.png> <output> [points]
//
// encodes the texture as field latents, tangent vectors at the points of the surface, remeshes the surface to about so many
// points (default 5000), gives it an atlas of its own, decodes the texture there, and writes <output>.vtp, with texture
// coordinates and colors at points, and <output>.png. The model is a file, or the name of an installed model.
#include "vtkFieldLatentDecoder.h"
#include "vtkFieldLatentEncoder.h"
#include "vtkIsotropicRemeshFilter.h"
#include "vtkTextureAtlasFilter.h"

#include <vtkDataSet.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkPolyData.h>
#include <vtkStaticCleanPolyData.h>
#include <vtkXMLPolyDataWriter.h>

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
  std::cout << what << ": " << made->GetNumberOfPoints() << " points\n";
}

template <typename Reader>
void Open(Reader* reader, const std::string& path)
{
  reader->SetFileName(path.c_str());
  reader->Update();
  if (reader->GetOutput()->GetNumberOfPoints() == 0)
  {
    throw std::runtime_error("cannot read " + path);
  }
}

template <typename Writer>
void Write(vtkAlgorithmOutput* source, const std::string& path)
{
  vtkNew<Writer> writer;
  writer->SetInputConnection(source);
  writer->SetFileName(path.c_str());
  writer->Write();
  if (writer->GetErrorCode() != 0)
  {
    throw std::runtime_error("cannot write " + path);
  }
}

void Transfer(const std::string& model, const std::string& surface, const std::string& texture,
  const std::string& output, int points)
{
  vtkNew<vtkOBJReader> textured;
  Open(textured.Get(), surface);
  vtkNew<vtkPNGReader> image;
  Open(image.Get(), texture);

  vtkNew<vtkFieldLatentEncoder> encoder;
  encoder->SetInputConnection(textured->GetOutputPort());
  encoder->SetTextureConnection(image->GetOutputPort());
  encoder->SetModelFileName(model.c_str());
  Run(encoder, "latents");

  vtkNew<vtkStaticCleanPolyData> closed; // points at seams of the texture are doubled
  closed->SetInputConnection(textured->GetOutputPort());
  closed->ToleranceIsAbsoluteOn();
  closed->SetAbsoluteTolerance(0.0);
  vtkNew<vtkIsotropicRemeshFilter> even;
  even->SetInputConnection(closed->GetOutputPort());
  even->SetTargetNumberOfPoints(points);
  even->KeepFeatureEdgesOff();
  vtkNew<vtkTextureAtlasFilter> atlas;
  atlas->SetInputConnection(even->GetOutputPort());
  Run(atlas, "atlas");

  vtkNew<vtkFieldLatentDecoder> decoder;
  decoder->SetInputConnection(encoder->GetOutputPort());
  decoder->SetTargetConnection(atlas->GetOutputPort());
  decoder->SetModelFileName(model.c_str());
  Run(decoder, "decoded");

  Write<vtkXMLPolyDataWriter>(decoder->GetOutputPort(0), output + ".vtp");
  Write<vtkPNGWriter>(decoder->GetOutputPort(1), output + ".png");
}
} // namespace

int main(int argc, char* argv[])
{
  if (argc < 5 || argc > 6)
  {
    std::cerr << "usage: TextureTransfer <model> <surface.obj> <texture.png> <output> [points]\n";
    return EXIT_FAILURE;
  }
  try
  {
    Transfer(argv[1], argv[2], argv[3], argv[4], argc > 5 ? std::stoi(argv[5]) : 5000);
  }
  catch (const std::exception& error)
  {
    std::cerr << "TextureTransfer: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
