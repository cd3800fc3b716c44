// SPDX-License-Identifier: BSD-3-Clause
#include "Fixtures.h"

#include "Core/Mesh/MeshTopology.h"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace surfsynth::test
{

std::string FindFixture(const std::string& name)
{
  for (const char* folder : { SURFACE_SYNTHESIS_PARITY_DATA, SURFACE_SYNTHESIS_PARITY_DIR })
  {
    const std::string path = std::string(folder) + "/" + name + ".safetensors";
    if (*folder && std::filesystem::exists(path))
    {
      return path;
    }
  }
  return "";
}

FixtureMatrix ReadMatrix(const SafetensorsFile& file, const std::string& tensor)
{
  const TensorEntry& entry = file.Entry(tensor);
  const std::vector<double> values = file.Float64(tensor);
  const Eigen::Index rows = entry.Shape.empty() ? 1 : entry.Shape[0];
  return Eigen::Map<const FixtureMatrix>(
    values.data(), rows, rows > 0 ? static_cast<Eigen::Index>(values.size()) / rows : 0);
}

TriangleMesh ReadMesh(const SafetensorsFile& file)
{
  TriangleMesh mesh;
  mesh.Points = ReadMatrix(file, "mesh.vertices_normalized");
  const std::vector<std::int64_t> ids = file.Integers("mesh.faces");
  mesh.Triangles.resize(static_cast<Eigen::Index>(ids.size()) / 3, 3);
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    mesh.Triangles.data()[k] = static_cast<Index>(ids[k]);
  }
  return mesh;
}

PoissonOperators ReadOperators(const SafetensorsFile& file)
{
  PoissonOperators operators;
  operators.Triangles = ReadMesh(file).Triangles;
  const Index faces = operators.NumberOfTriangles();
  operators.VertexMass = ReadMatrix(file, "op.vertex_mass").cast<float>();
  operators.FaceAreas.resize(faces);
  const std::vector<float> areas = file.Float32("op.M"); // each twice
  for (Index f = 0; f < faces; ++f)
  {
    operators.FaceAreas[f] = areas[2 * f];
  }

  // Six entries for each face: x components of corners 0, 1, 2, then y components.
  const std::vector<float> gradient = file.Float32("op.G.val");
  operators.Gradient = Eigen::Map<const FaceGradients>(gradient.data(), faces, 6);
  const std::vector<std::int64_t> columns = file.Integers("op.G.col");
  const std::vector<std::int64_t> rows = file.Integers("op.G.row");
  for (Index k = 0; k < 6 * faces; ++k)
  {
    if (columns[k] != operators.Triangles(k / 6, k % 3) || rows[k] != 2 * (k / 6) + (k % 6) / 3)
    {
      throw std::runtime_error("the gradient's entries are not in the order of the faces");
    }
  }

  const std::vector<double> values = file.Float64("op.L.val");
  const std::vector<std::int64_t> row = file.Integers("op.L.row");
  const std::vector<std::int64_t> column = file.Integers("op.L.col");
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t k = 0; k < values.size(); ++k)
  {
    entries.emplace_back(static_cast<Index>(row[k]), static_cast<Index>(column[k]), values[k]);
  }
  SparseMatrix stiffness(operators.NumberOfPoints(), operators.NumberOfPoints());
  stiffness.setFromTriplets(entries.begin(), entries.end());
  operators.Solver = FactorPoissonMatrix(stiffness);
  return operators;
}

PoissonOperators OwnOperators(const SafetensorsFile& file)
{
  const TriangleMesh mesh = ReadMesh(file);
  return BuildPoissonOperators(mesh, MeshTopology(mesh));
}

double RelativeError(const FixtureMatrix& a, const FixtureMatrix& b)
{
  return a.rows() == b.rows() && a.cols() == b.cols() ? (a - b).norm() / b.norm() : 1e300;
}

} // namespace surfsynth::test
