// SPDX-License-Identifier: BSD-3-Clause
// Geometric textures against the numbers of the published implementation: tables, features, convolutions and vertices
// of three levels. `ref.*` of the fixture was computed there in float64 from the same float32 inputs. README.md tables
// the limits.
#include "Fixtures.h"

#include "Core/Mesh/MidpointSubdivision.h"
#include "Core/Solvers/SingleThreadedBlas.h"
#include "Inference/GeometricTexture/FaceKernels.h"
#include "Inference/GeometricTexture/FaceNetwork.h"
#include "Inference/GeometricTexture/GeometricTextureSynthesis.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{
constexpr int Steps = 3;

class GeometricTextureParity : public testing::Test
{
protected:
  void SetUp() override
  {
    const std::string numbers = FindFixture("dgts/inference__dragknob");
    const std::string weights = FindFixture("dgts/generator_random");
    if (numbers.empty() || weights.empty())
    {
      GTEST_SKIP() << "dgts/* lies neither in Testing/Data/Parity nor in SURFACE_SYNTHESIS_PARITY_DIR";
    }
    this->File.emplace(numbers);
    const SafetensorsFile generator(weights);
    this->Model.Name = "random";
    for (const auto& [name, entry] : generator.Tensors())
    {
      this->Model.Generator[name] = { entry.Shape, generator.Float32(name) };
    }
    // The options of the fixture are the defaults; levels that the trimmed copy leaves out are not run.
    this->Model.Options.Levels = Steps;
    for (const auto& [name, shape] : ExpectedGeometricTextureTensors(this->Model.Options, false))
    {
      ASSERT_EQ(this->Model.Generator.count(name), 1U) << name;
      ASSERT_EQ(this->Model.Generator.at(name).Shape, shape) << name;
    }
  }

  std::string Name(int step, const std::string& what) const { return "s" + std::to_string(step) + "." + what; }
  FixtureMatrix Matrix(const std::string& name) const { return ReadMatrix(*this->File, name); }
  /// Published tables have a column for each face.
  FixtureMatrix Transposed(const std::string& name) const { return this->Matrix(name).transpose(); }

  FixtureMatrix IntegerMatrix(const std::string& name) const
  {
    const std::vector<std::int64_t> ids = this->File->Integers(name);
    const std::vector<double> numbers(ids.begin(), ids.end());
    const Eigen::Index rows = this->File->Entry(name).Shape[0];
    return Eigen::Map<const FixtureMatrix>(numbers.data(), rows, static_cast<Eigen::Index>(numbers.size()) / rows);
  }
  TriangleMatrix Triangles(const std::string& name) const { return this->IntegerMatrix(name).cast<Index>(); }
  TriangleMesh Input() const { return { this->Matrix("in.vs_unit_edge"), this->Triangles("in.faces") }; }
  /// The mesh that a step was given by the published code.
  TriangleMesh MeshOf(int step) const
  {
    return step == 0
      ? this->Input()
      : TriangleMesh{ this->Matrix(this->Name(step, "vs_in")), this->Triangles(this->Name(step, "faces")) };
  }
  /// [V, 3], or without rows where the step had none.
  SinglePoints Noise(int step) const
  {
    if (this->File->Integers("in.zero_places")[step] != 0)
    {
      return {};
    }
    return this->Matrix("in.noise" + std::to_string(step)).cast<float>();
  }
  SinglePoints NoisedPoints(int step) const
  {
    const SinglePoints points = this->MeshOf(step).Points.cast<float>();
    const SinglePoints noise = this->Noise(step);
    return noise.rows() > 0 ? SinglePoints(points + noise) : points;
  }

  std::optional<SafetensorsFile> File;
  GeometricTextureModel Model;
};
} // namespace

TEST_F(GeometricTextureParity, TheFrameOfTheInput)
{
  const TriangleMesh mesh{ this->Matrix("mesh.vertices"), this->Triangles("mesh.faces") };
  const GeometricTextureFrame frame = FrameOf(mesh, MeshTopology(mesh));
  const FixtureMatrix points = (mesh.Points.rowwise() - frame.Center) / frame.Unit;
  EXPECT_LE(RelativeError(points, this->Matrix("in.vs_unit_edge")), 1e-6);
}

TEST_F(GeometricTextureParity, NeighborsAndSubdivisionHaveThePublishedOrder)
{
  for (int step = 0; step < Steps; ++step)
  {
    const TriangleMesh mesh = this->MeshOf(step);
    const std::string table = this->Name(step, "gfmm");
    const FixtureMatrix neighbors = ComputeFaceNeighbors(mesh).Faces.cast<double>();
    EXPECT_EQ(neighbors, FixtureMatrix(this->IntegerMatrix(table).transpose())) << step;
    if (step + 1 < Steps)
    {
      TriangleMesh displaced = mesh;
      displaced.Points = this->Matrix(this->Name(step, "vs"));
      const TriangleMesh fine = SubdivideAtMidpoints(displaced).Mesh;
      EXPECT_EQ(fine.Triangles, this->Triangles(this->Name(step + 1, "faces")));
      EXPECT_LE(RelativeError(2.0 * fine.Points, this->Matrix(this->Name(step + 1, "vs_in"))), 1e-6);
    }
  }
}

TEST_F(GeometricTextureParity, FeaturesOfTheNoisedMesh)
{
  for (int step = 0; step < Steps; ++step)
  {
    const TriangleMesh mesh = this->MeshOf(step);
    const FixtureMatrix features =
      ComputeEdgeFeatures(this->NoisedPoints(step), mesh.Triangles, ComputeFaceNeighbors(mesh)).cast<double>();
    EXPECT_LE(RelativeError(features, this->Transposed(this->Name(step, "features"))), 1e-5) << step;
  }
}

TEST_F(GeometricTextureParity, TheFirstConvolution)
{
  const FixtureMatrix expected = this->Transposed("s0.first_conv");
  const EdgeFeatureMatrix features = this->Transposed("s0.features").cast<float>();
  const GeometricTextureTensorNames names = NamesOfConvolution(0, 0, this->Model.Options.Layers);
  const std::vector<float>& weight = this->Model.Generator.at(names.Weight).Values;
  const FaceNetwork::Output matrix =
    Eigen::Map<const FaceNetwork::Output>(weight.data(), expected.cols(), 4).transpose();
  FaceNetwork::Output out(expected.rows(), expected.cols());
  BestFaceKernels().EdgeMaps(features.data(), matrix.data(), this->Model.Generator.at(names.Bias).Values.data(),
    out.rows(), out.cols(), out.data());
  EXPECT_LE(RelativeError(out.cast<double>(), expected), 1e-6);
}

// Each step alone, from the mesh that the published code gave it.
TEST_F(GeometricTextureParity, DisplacementsInTheFramesOfFaces)
{
  const SingleThreadedBlas blas;
  for (int step = 0; step < Steps; ++step)
  {
    const TriangleMesh mesh = this->MeshOf(step);
    const FaceNeighbors neighbors = ComputeFaceNeighbors(mesh);
    const FaceNetwork network(this->Model.Generator, step, this->Model.Options.Layers);
    const EdgeFeatureMatrix features = ComputeEdgeFeatures(this->NoisedPoints(step), mesh.Triangles, neighbors);
    const SinglePoints local = network.Run(features, neighbors.Faces);
    const double limit = step == 0 ? 1e-5 : 1e-4;
    EXPECT_LE(RelativeError(local.cast<double>(), this->Transposed("ref." + this->Name(step, "deltas"))), limit)
      << step;
    const SinglePoints displacement = MeanCornerDisplacement(mesh.Points.cast<float>(), mesh.Triangles, local);
    EXPECT_LE(RelativeError(displacement.cast<double>(), this->Matrix(this->Name(step, "vertex_displacement"))), limit)
      << step;
  }
}

TEST_F(GeometricTextureParity, VerticesAfterAllLevels)
{
  const TriangleMesh mesh = this->Input();
  GeometricTextureSynthesis growth(this->Model, mesh, MeshTopology(mesh), {});
  for (int step = 0; step < Steps; ++step)
  {
    if (step > 0)
    {
      growth.Refine();
    }
    growth.Displace(step, { this->Noise(step) });
    const FixtureMatrix local = growth.LocalDisplacement().cast<double>();
    EXPECT_LE(RelativeError(local, this->Transposed("ref." + this->Name(step, "deltas"))), step == 0 ? 1e-5 : 1e-4)
      << step;
    EXPECT_LE(RelativeError(growth.LevelPoints().cast<double>(), this->Matrix(this->Name(step, "vs"))), 1e-6) << step;
  }
  EXPECT_LE(RelativeError(growth.LevelPoints().cast<double>(), this->Matrix("ref.vs")), 1e-6);
  const GeometricTextureLevel result = growth.Result(Steps - 1);
  EXPECT_EQ(result.Mesh.Triangles, this->Triangles("s2.faces"));
  EXPECT_LE(RelativeError(4.0 * result.Mesh.Points, this->Matrix("ref.vs")), 1e-6) << "in the input's units";
}
