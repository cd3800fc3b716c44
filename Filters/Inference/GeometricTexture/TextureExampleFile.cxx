// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/TextureExampleFile.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/MeshCheck.h"
#include "IO/Weights/SafetensorsFile.h"
#include "Inference/Common/ModelFile.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"

#include <cmath>
#include <vector>

namespace surfsynth
{

namespace
{
constexpr const char* ExampleArchitecture = "geometric_texture_example";
constexpr const char* ExampleKind = "an example of a geometric texture";
constexpr const char* ExamplePoints = "points";
constexpr const char* ExampleTriangles = "triangles";
constexpr const char* PlainPoints = "plain_points";
constexpr const char* ExampleDirections = "directions";
constexpr const char* LengthKey = "smoothing_length";

/// Shapes of the tensors that @p file must hold, given its optional parts.
TensorShapes ExpectedInExample(const SafetensorsFile& file)
{
  TensorShapes expected{ { ExamplePoints, { RowsIn(file, ExamplePoints), 3 } },
    { ExampleTriangles, { RowsIn(file, ExampleTriangles), 3 } } };
  for (const char* name : { PlainPoints, ExampleDirections })
  {
    if (file.Contains(name))
    {
      expected[name] = expected[ExamplePoints];
    }
  }
  return expected;
}

void RequireExample(const std::string& path, const TriangleMesh& mesh, const char* words)
{
  const std::vector<MeshFinding> findings = CheckMesh(mesh, GeometricTextureExample::Requirements());
  if (!findings.empty() || mesh.NumberOfTriangles() == 0)
  {
    throw ModelMismatch(path + ": the " + words +
      (findings.empty() ? " has no triangles; a surface is needed." : " is broken: " + DescribeFindings(findings)));
  }
}
} // namespace

TextureExampleFile ReadTextureExample(const std::string& path)
{
  const SafetensorsFile file(path);
  RequireArchitecture(file, ExampleArchitecture, ExampleKind);
  const DescriptionReader reader(file, ExampleArchitecture);
  TextureExampleFile example;
  example.Name = reader.String("name");
  RequireTensors(file, ExpectedInExample(file), ExampleKind, ExampleTriangles);
  example.Textured = { ReadPoints(file, ExamplePoints), ReadTriangles(file, ExampleTriangles) };
  RequireExample(path, example.Textured, "example");
  if (file.Contains(PlainPoints))
  {
    example.PlainPoints = ReadPoints(file, PlainPoints);
    RequireExample(path, { example.PlainPoints, example.Textured.Triangles }, "plain example");
  }
  else
  {
    example.SmoothingLength = reader.Number(LengthKey);
    if (!(example.SmoothingLength > 0.0) || !std::isfinite(example.SmoothingLength))
    {
      reader.Fail(LengthKey, "a finite number above 0");
    }
  }
  if (file.Contains(ExampleDirections))
  {
    example.Directions = ReadPoints(file, ExampleDirections);
  }
  return example;
}

} // namespace surfsynth
