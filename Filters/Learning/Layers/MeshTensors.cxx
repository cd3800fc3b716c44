// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/MeshTensors.h"

#include "Learning/Layers/FusedLayers.h"
#include "Learning/Layers/FusedPoisson.h"
#include "Learning/Layers/KeptValue.h"

namespace surfsynth
{

namespace
{
torch::Tensor SolveRows(const CholeskySolver& solver, const torch::Tensor& rightHandSide)
{
  // One row for each vertex with all channels of all leading dimensions, so that one pass over the factor serves them.
  const torch::Tensor byVertex = rightHandSide.movedim(-2, 0);
  const torch::Tensor rows =
    byVertex.to(torch::kCPU, torch::kFloat64).contiguous().clone().reshape({ byVertex.size(0), -1 });
  Eigen::Map<RowMatrix> map(rows.data_ptr<double>(), rows.size(0), rows.size(1));
  solver.SolveInPlace(map);
  return rows.reshape(byVertex.sizes()).movedim(0, -2).to(rightHandSide.device(), rightHandSide.scalar_type());
}

class PoissonSolve : public torch::autograd::Function<PoissonSolve>
{
public:
  static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& rightHandSide,
    const std::shared_ptr<const CholeskySolver>& solver)
  {
    KeepValue(context, solver);
    return SolveRows(*solver, rightHandSide);
  }
  static torch::autograd::variable_list backward(
    torch::autograd::AutogradContext* context, const torch::autograd::variable_list& gradients)
  {
    return { apply(gradients[0], KeptValue<std::shared_ptr<const CholeskySolver>>(context)), torch::Tensor() };
  }
};

/// Adds the rows of @p values [..., F, C] to those of the vertices at one corner of each face.
torch::Tensor AddAtCorner(const torch::Tensor& sums, const MeshTensors& mesh, int corner, const torch::Tensor& values)
{
  return sums.index_add(-2, mesh.Corners[corner], values);
}

torch::Tensor VertexZeros(const MeshTensors& mesh, const torch::Tensor& faceSignal)
{
  std::vector<std::int64_t> shape = faceSignal.sizes().vec();
  shape[shape.size() - 2] = mesh.VertexMass.size(0);
  return torch::zeros(shape, faceSignal.options());
}
} // namespace

MeshTensors::MeshTensors(
  const PoissonOperators& operators, const torch::TensorOptions& options, const PointMatrix& points)
  : Solver(operators.Solver)
{
  const std::int64_t faces = operators.NumberOfTriangles();
  const auto column = [&](Eigen::VectorXf values) {
    return torch::from_blob(values.data(), { values.size(), 1 }, torch::kFloat32).clone().to(options);
  };
  Eigen::VectorXf areaAround = Eigen::VectorXf::Zero(operators.NumberOfPoints());
  for (int k = 0; k < 3; ++k)
  {
    Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1> ids = operators.Triangles.col(k).cast<std::int64_t>();
    this->Corners[k] = torch::from_blob(ids.data(), { faces }, torch::kInt64).clone().to(options.device());
    this->BasisGradientX[k] = column(operators.Gradient.col(k));
    this->BasisGradientY[k] = column(operators.Gradient.col(3 + k));
    for (std::int64_t f = 0; f < faces; ++f)
    {
      areaAround[operators.Triangles(f, k)] += operators.FaceAreas[f] / 3.0F;
    }
  }
  this->FaceAreas = column(operators.FaceAreas);
  this->VertexMass = column(operators.VertexMass);
  this->InverseArea = column(areaAround.unaryExpr([](float area) { return area > 0.0F ? 1.0F / area : 0.0F; }));
  if ((areaAround.array() == 0.0F).any())
  {
    this->Used = column(areaAround.unaryExpr([](float area) { return area > 0.0F ? 1.0F : 0.0F; }));
  }
  if (IsFused(this->FaceAreas))
  {
    this->Incidence = std::make_shared<const FaceIncidence>(operators);
    this->Tables = std::make_shared<const PoissonTables>(operators, points);
  }
}

FaceSignal AtFaces(const MeshTensors& mesh, const torch::Tensor& signal)
{
  if (mesh.Incidence)
  {
    const std::array<torch::Tensor, 3> parts = FusedGatherFaces(mesh.Incidence, signal);
    return { { parts[0], parts[1] }, parts[2] };
  }
  return { FaceGradient(mesh, signal), FaceMean(mesh, signal) };
}

ComplexTensor FaceGradient(const MeshTensors& mesh, const torch::Tensor& signal)
{
  if (mesh.Incidence)
  {
    return AtFaces(mesh, signal).Gradient;
  }
  ComplexTensor gradient;
  for (int k = 0; k < 3; ++k)
  {
    const torch::Tensor corner = signal.index_select(-2, mesh.Corners[k]);
    gradient.Real = k == 0 ? corner * mesh.BasisGradientX[k] : gradient.Real + corner * mesh.BasisGradientX[k];
    gradient.Imaginary = k == 0 ? corner * mesh.BasisGradientY[k]
                                : gradient.Imaginary + corner * mesh.BasisGradientY[k];
  }
  return gradient;
}

torch::Tensor IntegratedDivergence(const MeshTensors& mesh, const ComplexTensor& gradients)
{
  if (mesh.Incidence)
  {
    return FusedDivergence(mesh.Incidence, gradients.Real, gradients.Imaginary);
  }
  const torch::Tensor x = gradients.Real * mesh.FaceAreas;
  const torch::Tensor y = gradients.Imaginary * mesh.FaceAreas;
  torch::Tensor sums = VertexZeros(mesh, x);
  for (int k = 0; k < 3; ++k)
  {
    sums = AddAtCorner(sums, mesh, k, x * mesh.BasisGradientX[k] + y * mesh.BasisGradientY[k]);
  }
  return sums;
}

torch::Tensor FaceMean(const MeshTensors& mesh, const torch::Tensor& signal)
{
  if (mesh.Incidence)
  {
    return AtFaces(mesh, signal).Mean;
  }
  return (signal.index_select(-2, mesh.Corners[0]) + signal.index_select(-2, mesh.Corners[1]) +
           signal.index_select(-2, mesh.Corners[2])) /
    3.0;
}

torch::Tensor VertexMean(const MeshTensors& mesh, const torch::Tensor& faceSignal)
{
  const torch::Tensor weighted = faceSignal * (mesh.FaceAreas / 3.0);
  torch::Tensor sums = VertexZeros(mesh, weighted);
  for (int k = 0; k < 3; ++k)
  {
    sums = AddAtCorner(sums, mesh, k, weighted);
  }
  return sums * mesh.InverseArea;
}

torch::Tensor MassMean(const MeshTensors& mesh, const torch::Tensor& signal)
{
  return (signal * mesh.VertexMass).sum(-2, true) / mesh.VertexMass.sum();
}

torch::Tensor SolvePoisson(const MeshTensors& mesh, const torch::Tensor& rightHandSide)
{
  return mesh.DenseInverse.defined() ? torch::matmul(mesh.DenseInverse, rightHandSide)
                                     : PoissonSolve::apply(rightHandSide, mesh.Solver);
}

torch::Tensor WithoutMean(const MeshTensors& mesh, const torch::Tensor& solution)
{
  const torch::Tensor centered = solution - MassMean(mesh, solution);
  return mesh.Used.defined() ? centered * mesh.Used : centered;
}

torch::Tensor Interleaved(const ComplexTensor& gradients)
{
  std::vector<std::int64_t> shape = gradients.Real.sizes().vec();
  shape[shape.size() - 2] *= 2;
  return torch::stack({ gradients.Real, gradients.Imaginary }, -2).reshape(shape);
}

} // namespace surfsynth
