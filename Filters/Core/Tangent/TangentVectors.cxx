// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Tangent/TangentVectors.h"

#include "Core/Common/Errors.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <cmath>
#include <string>

namespace surfsynth
{

namespace
{
void RequireRows(const char* function, const VertexFrames& frames, Eigen::Index rows)
{
  if (frames.X.rows() != rows)
  {
    throw InvalidInput(std::string(function) + ": " + std::to_string(rows) + " rows; expected " +
      std::to_string(frames.X.rows()) + ", one for each vertex.");
  }
}
} // namespace

Eigen::VectorXcd ToTangent(const VertexFrames& frames, const Eigen::Ref<const PointMatrix>& vectors)
{
  RequireRows("ToTangent", frames, vectors.rows());
  Eigen::VectorXcd tangents(vectors.rows());
  ParallelFor(vectors.rows(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      tangents[v] = { vectors.row(v).dot(frames.X.row(v)), vectors.row(v).dot(frames.Y.row(v)) };
    }
  });
  return tangents;
}

PointMatrix FromTangent(const VertexFrames& frames, const Eigen::Ref<const Eigen::VectorXcd>& tangents)
{
  RequireRows("FromTangent", frames, tangents.rows());
  PointMatrix vectors(tangents.rows(), 3);
  ParallelFor(tangents.rows(), FineGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
    {
      vectors.row(v) = tangents[v].real() * frames.X.row(v) + tangents[v].imag() * frames.Y.row(v);
    }
  });
  return vectors;
}

VertexFrames TurnedFrames(const VertexFrames& frames, const Eigen::Ref<const Eigen::VectorXd>& angles)
{
  RequireRows("TurnedFrames", frames, angles.rows());
  VertexFrames turned = frames;
  for (Eigen::Index v = 0; v < angles.rows(); ++v)
  {
    const double cosine = std::cos(angles[v]);
    const double sine = std::sin(angles[v]);
    turned.X.row(v) = cosine * frames.X.row(v) + sine * frames.Y.row(v);
    turned.Y.row(v) = cosine * frames.Y.row(v) - sine * frames.X.row(v);
  }
  return turned;
}

} // namespace surfsynth
