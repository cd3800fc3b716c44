// SPDX-License-Identifier: BSD-3-Clause
#include "SampledTextures.h"

#include "Core/Common/Errors.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "AtlasDataset.h"
#endif

#include <vtkPolyData.h>

namespace surfsynth
{

#ifdef SURFACE_SYNTHESIS_CGAL
MadeAtlas::MadeAtlas(vtkPolyData* input, const Surface& surface, const int size[2], const Progress& progress)
  : Size{ size[0], size[1] }
{
  SurfaceAtlasOptions options;
  options.Width = size[0];
  options.Height = size[1];
  const auto whole = std::make_shared<const Surface>(surface);
  this->Atlas = std::make_shared<const SurfaceAtlas>(MakeAtlas(input, whole, options, progress));
}

void MadeAtlas::Fill(vtkPolyData* input, const Surface& surface, vtkPolyData* output) const
{
  FillAtlas(input, surface, *this->Atlas, output);
}
#else
MadeAtlas::MadeAtlas(vtkPolyData*, const Surface&, const int size[2], const Progress&)
  : Size{ size[0], size[1] }
{
  throw InvalidInput("The surface has no texture coordinates, and an atlas for it needs CGAL, which this library was "
                     "built without (SURFACE_SYNTHESIS_CGAL is off). Texture coordinates, or a build with CGAL, are "
                     "needed.");
}

void MadeAtlas::Fill(vtkPolyData*, const Surface&, vtkPolyData*) const {}
#endif

} // namespace surfsynth
