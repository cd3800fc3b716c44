// SPDX-License-Identifier: BSD-3-Clause
#include "TextureExampleInput.h"

#include "PointRows.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshTopology.h"
#include "Core/Mesh/UsedPoints.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Statistics/GeometricTextureFeatures.h"

#include <vtkInformationVector.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cmath>

namespace surfsynth
{

namespace
{
constexpr double SmoothingOfRootArea = 0.1;

/// Returns the surface on a port. @param words begins messages
vtkSmartPointer<vtkPolyData> RequireSurface(vtkInformationVector* port, const std::string& words)
{
  auto found = SurfaceOn(port);
  if (!found || found->GetNumberOfCells() == 0)
  {
    throw InvalidInput(
      words + (found ? " is empty" : " is no surface") + "; a vtkPolyData with a geometric texture is needed.");
  }
  return found;
}

/// Calls work(), and begins the text of an error with words.
template <typename Work>
auto Named(const std::string& words, const Work& work)
{
  try
  {
    return work();
  }
  catch (const InvalidInput& error)
  {
    throw InvalidInput(words + ": " + error.what());
  }
}

Surface Convert(vtkPolyData* data, const std::string& words)
{
  return Named(words, [&] { return ToSurface(data, GeometricTextureExample::Requirements()); });
}
} // namespace

bool TextureExampleInput::Key::operator==(const Key& other) const
{
  return this->Textured == other.Textured && this->Plain == other.Plain && this->File == other.File &&
    this->SmoothingLength == other.SmoothingLength && this->Directions.rows() == other.Directions.rows() &&
    (this->Directions.array() == other.Directions.array()).all();
}

void TextureExampleInput::Read(vtkInformationVector* textured, vtkInformationVector* plain,
  const std::string& orientationArrayName, double smoothingLength)
{
  const vtkSmartPointer<vtkPolyData> data = RequireSurface(textured, this->Words.Textured);
  const Surface surface = Convert(data, this->Words.Textured);
  const UsedPoints points(surface.Mesh);
  Key key;
  key.Textured = surface.MeshHash();
  if (!orientationArrayName.empty())
  {
    key.Directions = Named(this->Words.Textured, [&] {
      return ReadPointRows(data, points, { orientationArrayName, "ExampleOrientationArrayName" }, 3);
    });
  }
  std::optional<Surface> form;
  if (plain->GetNumberOfInformationObjects() > 0)
  {
    form = Convert(RequireSurface(plain, this->Words.Plain), this->Words.Plain);
    key.Plain = form->MeshHash();
    if (form->Mesh.NumberOfPoints() != surface.Mesh.NumberOfPoints())
    {
      throw InvalidInput(this->Words.Plain + " has " + std::to_string(form->Mesh.NumberOfPoints()) +
        " points in place of " + std::to_string(surface.Mesh.NumberOfPoints()) +
        "; the same triangles with other points are needed.");
    }
  }
  else
  {
    key.SmoothingLength = smoothingLength;
  }
  if (key == this->Known && this->Textured.NumberOfTriangles() > 0)
  {
    return;
  }
  this->Clear(); // so that nothing stale is left where memory ends
  this->Textured = points.Compact(surface.Mesh);
  if (form)
  {
    this->Form = UsedPoints(form->Mesh).Compact(form->Mesh);
  }
  this->Known = std::move(key);
}

void TextureExampleInput::Read(
  const std::shared_ptr<const TextureExampleFile>& file, bool isOriented, double smoothingLength)
{
  Key key;
  key.File = file;
  if (isOriented)
  {
    if (file->Directions.rows() == 0)
    {
      throw InvalidInput(this->Words.FileName + ": \"" + file->Name +
        "\" has no direction; an example with one is needed with OrientationArrayName.");
    }
    key.Directions = file->Directions;
  }
  if (file->PlainPoints.rows() == 0)
  {
    key.SmoothingLength = smoothingLength > 0.0 ? smoothingLength : file->SmoothingLength;
  }
  if (key == this->Known)
  {
    return;
  }
  this->Clear();
  this->Textured = file->Textured;
  if (file->PlainPoints.rows() > 0)
  {
    this->Form = { file->PlainPoints, file->Textured.Triangles };
  }
  this->Known = std::move(key);
}

/// Smooths the example where there is no plain one.
void TextureExampleInput::FindForm()
{
  if (!this->Form)
  {
    const MeshTopology topology(this->Textured);
    const double automatic = SmoothingOfRootArea * std::sqrt(LumpedMass(this->Textured, topology).sum());
    this->Margin = this->Known.SmoothingLength > 0.0 ? this->Known.SmoothingLength : automatic;
    this->Form = SmoothedForm(this->Textured, topology, this->Margin);
  }
}

void TextureExampleInput::Clear()
{
  this->Known = {};
  this->Textured = {};
  this->Form.reset();
  this->Margin = 0.0;
  this->Cut.reset();
  this->Counts.reset();
}

ExampleScaleCounts TextureExampleInput::Scales()
{
  if (!this->Counts)
  {
    this->FindForm();
    this->Counts = Named(this->Source(), [&] { return CountExampleScales(this->Textured, *this->Form); });
  }
  return *this->Counts;
}

std::shared_ptr<const GeometricTextureExample> TextureExampleInput::Patches(int scales, const Progress& progress)
{
  if (!this->Cut || this->CutScales != scales)
  {
    this->Cut.reset();
    this->FindForm();
    GeometricTextureExampleOptions options;
    options.Scales = scales;
    options.Directions = this->Known.Directions;
    options.Margin = this->Margin;
    this->Cut = Named(this->Source(),
      [&] { return std::make_shared<const GeometricTextureExample>(this->Textured, *this->Form, options, progress); });
    this->CutScales = scales;
  }
  return this->Cut;
}

} // namespace surfsynth
