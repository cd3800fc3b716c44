// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/GeometricTexture/PatchFit.h"

#include "Core/Common/Parallel.h"

#include <utility>

namespace surfsynth
{

namespace
{
/// Weights in a fit, over that of a sample at the center: of the earlier displacement, and of the squared difference of the
/// displacements at the ends of an edge, for each of its triangles. They count where no patch is.
constexpr float EarlierWeight = 1e-5F, DifferenceWeight = 3e-3F;
constexpr int Iterations = 15;
/// Parts of the patches that add to the right-hand side at the same time.
constexpr std::int64_t RightHandSideParts = 4;
/// Power of the weights of the samples: where patches do not agree, the one with the nearest center prevails, and their mean
/// blurs less.
constexpr float Sharpness = 3.0F;

Eigen::Array3f Dot(const SinglePoints& a, const SinglePoints& b)
{
  return a.cast<double>().cwiseProduct(b.cast<double>()).colwise().sum().cast<float>().transpose();
}
} // namespace

PatchFit::PatchFit(const TriangleMesh& mesh, std::vector<const TexturePatches*> sets)
  : Mesh(mesh)
  , Sets(std::move(sets))
  , Weights(PatchWeights().array().pow(Sharpness))
{}

void PatchFit::Weigh(std::vector<Eigen::VectorXf> factors)
{
  this->Factors = std::move(factors);
  this->Products = TexturePatches::TriangleProducts::Zero(this->Mesh.NumberOfTriangles(), 6);
  for (std::size_t set = 0; set < this->Sets.size(); ++set)
  {
    this->Products += this->Sets[set]->Products(this->Weights, this->Factors[set]);
  }
  this->Products.leftCols<3>().array() += 2.0F * DifferenceWeight;
  this->Products.rightCols<3>().array() -= DifferenceWeight;
  this->Diagonal = Eigen::VectorXf::Constant(this->Mesh.NumberOfPoints(), EarlierWeight);
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      this->Diagonal(this->Mesh.Triangles(f, k)) += this->Products(f, k);
    }
  }
}

void PatchFit::Fit(const RowOfPatch& rowOf, SinglePoints& displacement) const
{
  SinglePoints residual = this->RightHandSide(rowOf, displacement) - this->Apply(displacement);
  SinglePoints direction = this->Divide(residual);
  Eigen::Array3f projected = Dot(residual, direction);
  for (int iteration = 0; iteration < Iterations; ++iteration)
  {
    const SinglePoints product = this->Apply(direction);
    const Eigen::Array3f curvature = Dot(direction, product);
    const Eigen::Array3f step = (curvature > 0.0F).select(projected / curvature, 0.0F);
    displacement += direction * step.matrix().asDiagonal();
    residual -= product * step.matrix().asDiagonal();
    const SinglePoints conditioned = this->Divide(residual);
    const Eigen::Array3f next = Dot(residual, conditioned);
    const Eigen::Array3f ratio = (projected > 0.0F).select(next / projected, 0.0F);
    direction = conditioned + direction * ratio.matrix().asDiagonal();
    projected = next;
  }
}

/// Returns the right-hand side of the fit, in parts that do not depend on the number of threads.
SinglePoints PatchFit::RightHandSide(const RowOfPatch& rowOf, const SinglePoints& displacement) const
{
  std::vector<SinglePoints> parts(RightHandSideParts);
  ParallelTasks(RightHandSideParts, [&](std::int64_t part) {
    SinglePoints& sum = parts[static_cast<std::size_t>(part)];
    sum = SinglePoints::Zero(displacement.rows(), 3);
    for (std::size_t set = 0; set < this->Sets.size(); ++set)
    {
      const std::int64_t count = this->Sets[set]->Count();
      for (std::int64_t p = part * count / RightHandSideParts; p < (part + 1) * count / RightHandSideParts; ++p)
      {
        this->Sets[set]->AddWeighted(p, rowOf(set, p), this->Weights, this->Factors[set](p), sum);
      }
    }
  });
  SinglePoints rightHandSide = EarlierWeight * displacement;
  for (const SinglePoints& part : parts)
  {
    rightHandSide += part;
  }
  return rightHandSide;
}

SinglePoints PatchFit::Divide(const SinglePoints& rows) const
{
  return this->Diagonal.cwiseInverse().asDiagonal() * rows;
}

SinglePoints PatchFit::Apply(const SinglePoints& x) const
{
  SinglePoints y = EarlierWeight * x;
  for (Index f = 0; f < this->Mesh.NumberOfTriangles(); ++f)
  {
    const auto v = this->Mesh.Triangles.row(f);
    const auto p = this->Products.row(f);
    const Eigen::RowVector3f a = x.row(v(0)), b = x.row(v(1)), c = x.row(v(2));
    y.row(v(0)) += p(0) * a + p(3) * b + p(5) * c;
    y.row(v(1)) += p(3) * a + p(1) * b + p(4) * c;
    y.row(v(2)) += p(5) * a + p(4) * b + p(2) * c;
  }
  return y;
}

} // namespace surfsynth
