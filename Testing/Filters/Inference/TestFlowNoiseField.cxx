// SPDX-License-Identifier: BSD-3-Clause
// The noise that a flow begins with: Matérn noise, smoothed so that its gradients do not depend on the triangulation.
#include "ExampleMeshes.h"

#include "Core/Mesh/MeshCheck.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Inference/FlowMatching/FlowNoiseField.h"
#include "Inference/PoissonNet/MeshNormalization.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace surfsynth;

namespace
{

/// A sphere of area 1, [V, samples] fields on it.
struct Fields
{
  TriangleMesh Mesh;
  Eigen::MatrixXd Values;

  Fields(int subdivisions, const FlowNoise& noise, std::uint32_t samples, std::uint32_t components = 1)
    : Mesh(test::Icosphere(subdivisions))
  {
    this->Mesh = Normalized(this->Mesh, FlowNormalization(this->Mesh));
    const FlowNoiseField field(this->Mesh, RequireValidMesh(this->Mesh), noise);
    RowMatrix sample(this->Mesh.NumberOfPoints(), components);
    this->Values.resize(this->Mesh.NumberOfPoints(), samples * components);
    SampleRequest request;
    request.Seed = 11;
    request.NumberOfComponents = components;
    for (std::uint32_t k = 0; k < samples; ++k)
    {
      request.FirstSample = k;
      field.SampleInto(request, [&](std::uint32_t) { return sample.data(); });
      this->Values.middleCols(k * components, components) = sample;
    }
  }

  /// Mean over the fields of the integral of the squared gradient.
  double GradientEnergy() const
  {
    return (this->Values.transpose() * CotangentStiffness(this->Mesh) * this->Values).trace() /
      static_cast<double>(this->Values.cols());
  }
  /// Mean over the fields of the integral of the square.
  double Energy() const
  {
    return (LumpedMass(this->Mesh).transpose() * this->Values.cwiseAbs2()).sum() /
      static_cast<double>(this->Values.cols());
  }
};

FlowNoise Smoothed(double smoothing)
{
  FlowNoise noise;
  noise.Smoothing = smoothing;
  return noise;
}

} // namespace

TEST(FlowNoiseField, WithoutSmoothingItIsTheMaternField)
{
  const Fields fields(3, Smoothed(0.0), 2, 3);
  MaternFieldOptions options;
  options.Mode = ScaleMode::Screening;
  SampleRequest request;
  request.Seed = 11;
  request.NumberOfComponents = 3;
  request.FirstSample = 1;
  EXPECT_EQ(fields.Values.rightCols(3), MaternField(fields.Mesh, options).Sample(request));
}

TEST(FlowNoiseField, SmoothingSolvesAScreenedPoissonEquation)
{
  const double s = 2e-3;
  const Fields plain(3, Smoothed(0.0), 2, 2);
  const Fields smooth(3, Smoothed(s), 2, 2);
  const Eigen::VectorXd mass = LumpedMass(plain.Mesh);
  const Eigen::MatrixXd left = mass.asDiagonal() * smooth.Values + s * CotangentStiffness(plain.Mesh) * smooth.Values;
  const Eigen::MatrixXd right = mass.asDiagonal() * plain.Values;
  EXPECT_LT((left - right).norm(), 1e-10 * right.norm());
  EXPECT_LT(smooth.GradientEnergy(), 0.8 * plain.GradientEnergy());
  EXPECT_LT(smooth.Energy(), plain.Energy());
  EXPECT_GT(smooth.Energy(), 0.5 * plain.Energy());
}

TEST(FlowNoiseField, SmoothedGradientsDoNotGrowWithTheNumberOfVertices)
{
  // On the sphere of area 1, eigenvalue 4 pi l (l + 1) with multiplicity 2 l + 1.
  const auto expected = [](double s) {
    double sum = 0.0;
    for (int l = 1; l < 20000; ++l)
    {
      const double lambda = 4.0 * std::acos(-1.0) * l * (l + 1.0);
      sum += (2 * l + 1) * lambda / std::pow((lambda + 100.0) * (1.0 + s * lambda), 2);
    }
    return sum;
  };
  const double s = 1e-3;
  const double coarse = Fields(4, Smoothed(s), 60).GradientEnergy(); // of edges that resolve sqrt(s)
  const double fine = Fields(5, Smoothed(s), 60).GradientEnergy();
  EXPECT_NEAR(fine / expected(s), 1.0, 0.05); // a sampling error of 1 %
  EXPECT_NEAR(coarse / fine, 1.0, 0.1);
  EXPECT_GT(Fields(5, Smoothed(0.0), 60).GradientEnergy(), 1.5 * Fields(3, Smoothed(0.0), 60).GradientEnergy());
}

TEST(FlowNoiseField, EachKindOfNoiseIsSmoothedByTheSameEquation)
{
  const double s = 1e-2;
  for (const NoiseModel model :
    { NoiseModel::PerVertex, NoiseModel::White, NoiseModel::Unscreened, NoiseModel::Spectral })
  {
    FlowNoise noise = Smoothed(0.0);
    noise.Model = model;
    noise.Eigenpairs = 40;
    const Fields plain(2, noise, 2, 2);
    noise.Smoothing = s;
    const Fields smooth(2, noise, 2, 2);
    const Eigen::VectorXd mass = LumpedMass(plain.Mesh);
    const Eigen::MatrixXd left = mass.asDiagonal() * smooth.Values + s * CotangentStiffness(plain.Mesh) * smooth.Values;
    const Eigen::MatrixXd right = mass.asDiagonal() * plain.Values;
    EXPECT_LT((left - right).norm(), 1e-10 * right.norm()) << static_cast<int>(model);
    EXPECT_LT(smooth.GradientEnergy(), 0.8 * plain.GradientEnergy()) << static_cast<int>(model);
  }
}
