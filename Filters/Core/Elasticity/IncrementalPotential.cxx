// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Elasticity/IncrementalPotential.h"

#include "Core/Mesh/TetrahedralMesh.h"

#include <algorithm>

namespace surfsynth
{

namespace
{
/// Pressure of contact at half of its distance, as a fraction of Young's modulus.
constexpr double ContactPressure = 0.1;
/// Speed below which friction grows with the speed, in diagonals of the body per second.
constexpr double SlipSpeed = 1e-3;
} // namespace

IncrementalPotential::IncrementalPotential(const ElasticBody& body, const ElasticSurroundings& surroundings)
  : Body(body)
  , Surroundings(surroundings)
  , Start(body.Mesh().Points)
  , Inertia(body.Mesh().Points)
{
  const BoundingBox box = ComputeBoundingBox(body.Mesh());
  const double diagonal = (box.Upper - box.Lower).norm();
  const Barrier barrier = Barrier::OfPressure(
    surroundings.ContactDistance * diagonal, ContactPressure * body.Material().YoungsModulus);
  if (surroundings.HasFloor)
  {
    this->Floor.emplace(barrier, body.BoundaryAreas(), surroundings.Friction, SlipSpeed * diagonal);
  }
  if (surroundings.HasSelfContact)
  {
    this->Self.emplace(barrier, body.Boundary(), body.BoundaryAreas(), body.Mesh().Points);
  }
}

void IncrementalPotential::Begin(const PointMatrix& points, const PointMatrix& velocities, double step)
{
  this->Step = step;
  this->Start = points;
  this->Inertia = points + step * velocities;
  if (this->Floor)
  {
    this->Floor->Begin(points, step);
  }
}

void IncrementalPotential::PrepareMove(const PointMatrix& points, const PointMatrix& move)
{
  if (this->Self)
  {
    this->Self->Find(points, move);
  }
}

double IncrementalPotential::PotentialEnergy(const PointMatrix& points) const
{
  double energy = this->Body.Energy(points);
  energy += this->Surroundings.Gravity * this->Body.Masses().dot(points.col(2));
  if (this->Surroundings.Loads.rows() > 0)
  {
    energy -= this->Surroundings.Loads.cwiseProduct(points).sum();
  }
  energy += this->Surroundings.Tethers.Energy(points);
  energy += this->Floor ? this->Floor->Energy(points) : 0.0;
  energy += this->Self ? this->Self->Energy(points) : 0.0;
  return energy;
}

double IncrementalPotential::Value(const PointMatrix& points) const
{
  const Eigen::VectorXd& masses = this->Body.Masses();
  const double inertia = masses.dot((points - this->Inertia).rowwise().squaredNorm());
  const double damping = masses.dot((points - this->Start).rowwise().squaredNorm());
  return 0.5 * inertia / (this->Step * this->Step) + 0.5 * this->Surroundings.Damping * damping / this->Step +
    this->PotentialEnergy(points) + (this->Floor ? this->Floor->FrictionEnergy(points) : 0.0);
}

PointMatrix IncrementalPotential::Imbalance(const PointMatrix& points) const
{
  PointMatrix gradient = PointMatrix::Zero(points.rows(), 3);
  gradient.col(2) = this->Surroundings.Gravity * this->Body.Masses();
  if (this->Surroundings.Loads.rows() > 0)
  {
    gradient -= this->Surroundings.Loads;
  }
  this->Body.AddGradient(points, gradient);
  this->Surroundings.Tethers.AddGradient(points, gradient);
  if (this->Floor)
  {
    this->Floor->AddGradient(points, gradient);
  }
  if (this->Self)
  {
    this->Self->AddGradient(points, gradient);
  }
  this->ClearFixed(gradient);
  return gradient;
}

PointMatrix IncrementalPotential::Gradient(const PointMatrix& points) const
{
  PointMatrix gradient = (points - this->Inertia) / (this->Step * this->Step);
  gradient += this->Surroundings.Damping / this->Step * (points - this->Start);
  gradient = this->Body.Masses().asDiagonal() * gradient;
  this->ClearFixed(gradient);
  return gradient + this->Imbalance(points);
}

void IncrementalPotential::FillStiffness(const PointMatrix& points, NodeMatrix& stiffness) const
{
  const double inertia = 1.0 / (this->Step * this->Step) + this->Surroundings.Damping / this->Step;
  stiffness.SetZero();
  for (Index v = 0; v < points.rows(); ++v)
  {
    stiffness.Add(v, v, inertia * this->Body.Masses()[v] * Eigen::Matrix3d::Identity());
  }
  this->Body.AddStiffness(points, stiffness);
  this->Surroundings.Tethers.AddStiffness(stiffness);
  if (this->Floor)
  {
    this->Floor->AddStiffness(points, stiffness);
  }
  if (this->Self)
  {
    this->Self->AddStiffness(points, stiffness);
  }
  if (!this->Surroundings.IsFixed.empty())
  {
    stiffness.Fix(this->Surroundings.IsFixed, inertia * this->Body.Masses().mean());
  }
}

std::vector<NodePair> IncrementalPotential::Coupled(const PointMatrix& points) const
{
  return this->Self ? this->Self->Coupled(points) : std::vector<NodePair>();
}

double IncrementalPotential::LargestStep(const PointMatrix& points, const PointMatrix& move) const
{
  const double part = this->Floor ? this->Floor->LargestStep(points, move) : 1.0;
  return this->Self ? std::min(part, this->Self->LargestStep(points, move)) : part;
}

void IncrementalPotential::ClearFixed(PointMatrix& rows) const
{
  for (std::size_t v = 0; v < this->Surroundings.IsFixed.size(); ++v)
  {
    if (this->Surroundings.IsFixed[v])
    {
      rows.row(static_cast<Eigen::Index>(v)).setZero();
    }
  }
}

} // namespace surfsynth
