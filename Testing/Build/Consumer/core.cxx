// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Samples a random field on an octahedron with the core alone.
#include <Core/Noise/MaternField.h>

#include <iostream>

int main()
{
  surfsynth::TriangleMesh mesh;
  mesh.Points.resize(6, 3);
  mesh.Points << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  mesh.Triangles.resize(8, 3);
  mesh.Triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;

  surfsynth::MaternFieldOptions options;
  options.CorrelationRange = 1.0;
  const surfsynth::MaternField field(mesh, options);
  const Eigen::MatrixXd values = field.Sample();
  if (values.rows() != 6 || values.cols() != 1 || !values.allFinite() || values.isZero())
  {
    std::cerr << "expected 6 finite numbers, not all zero, but got\n" << values << "\n";
    return 1;
  }
  if (!(field.RelativeResidual() <= 1e-10))
  {
    std::cerr << "relative residual " << field.RelativeResidual() << "\n";
    return 1;
  }
  std::cout << values.transpose() << "\n";
  return 0;
}
