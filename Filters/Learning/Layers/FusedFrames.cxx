// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/FusedFrames.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"

#include <ATen/Parallel.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <functional>

namespace surfsynth
{

namespace
{
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

using Vector = Eigen::Vector3f;
constexpr std::int64_t FrameGrain = 512; ///< triangles of a task

/// Refuses second derivatives: only their computation records a backward pass.
void RefuseSecondFrameDerivatives()
{
  if (torch::GradMode::is_enabled())
  {
    throw InvalidInput("FusedFrames: second derivatives of float32 features on the processor are asked for; expected "
                       "first ones (float64 has both).");
  }
}

Vector VectorAt(const float* values) { return { values[0], values[1], values[2] }; }

/// A vector as length and direction; the direction of 0 is 0 and has no derivative.
struct Direction
{
  explicit Direction(const Vector& vector)
    : Length(vector.norm())
    , Unit(this->Length > 0.0F ? Vector(vector / this->Length) : Vector(Vector::Zero()))
  {}
  /// The derivative by the vector from that by the direction.
  Vector Backward(const Vector& byUnit) const
  {
    return this->Length > 0.0F ? Vector((byUnit - this->Unit * this->Unit.dot(byUnit)) / this->Length)
                               : Vector(Vector::Zero());
  }
  float Length;
  Vector Unit;
};

/// Frames of the three edges of a triangle.
struct TriangleFrames
{
  TriangleFrames(const float* positions, const std::int64_t* triangle)
    : Corner{ VectorAt(positions + 3 * triangle[0]), VectorAt(positions + 3 * triangle[1]),
      VectorAt(positions + 3 * triangle[2]) }
    , Edge{ Vector(Corner[1] - Corner[0]), Vector(Corner[2] - Corner[1]), Vector(Corner[0] - Corner[2]) }
    , Along{ Direction(Edge[0]), Direction(Edge[1]), Direction(Edge[2]) }
    , Normal(Edge[0].cross(Edge[1]))
  {}
  Vector Outward(std::size_t edge) const { return this->Along[edge].Unit.cross(this->Normal.Unit); }
  Vector Midpoint(std::size_t edge) const { return 0.5F * (this->Corner[edge] + this->Corner[(edge + 1) % 3]); }

  std::array<Vector, 3> Corner;
  std::array<Vector, 3> Edge;
  std::array<Direction, 3> Along;
  Direction Normal;
};

/// Derivatives by what a triangle depends on, of its frames first.
struct FrameDerivatives
{
  /// Adds the derivative by the outward vector of an edge to those by its factors.
  void AddOutward(const TriangleFrames& frames, std::size_t edge, const Vector& byOutward)
  {
    this->Along[edge] += frames.Normal.Unit.cross(byOutward);
    this->Normal += byOutward.cross(frames.Along[edge].Unit);
  }

  /// Adds the derivatives by the frames to those by the corners.
  void Finish(const TriangleFrames& frames)
  {
    const Vector byNormal = frames.Normal.Backward(this->Normal);
    std::array<Vector, 3> byEdge;
    for (std::size_t k = 0; k < 3; ++k)
    {
      byEdge[k] = frames.Along[k].Backward(this->Along[k]) + this->Length[k] * frames.Along[k].Unit;
    }
    byEdge[0] += frames.Edge[1].cross(byNormal);
    byEdge[1] += byNormal.cross(frames.Edge[0]);
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Corner[k] -= byEdge[k];
      this->Corner[(k + 1) % 3] += byEdge[k];
    }
  }

  std::array<Vector, 3> Along = { Vector::Zero(), Vector::Zero(), Vector::Zero() };
  std::array<float, 3> Length{};
  Vector Normal = Vector::Zero();
  std::array<Vector, 3> Corner = { Vector::Zero(), Vector::Zero(), Vector::Zero() };
  std::array<Vector, 3> Opposite = { Vector::Zero(), Vector::Zero(), Vector::Zero() };
};

void ForTriangles(std::int64_t faces, const std::function<void(std::int64_t, std::int64_t)>& body)
{
  const ThreadScope threads(at::get_num_threads());
  ParallelFor(faces, FrameGrain, body);
}

/// Adds vectors of triangles, [F, 3, 3], to the rows of @p sums at the ids, [F, 3]; in order.
void AddToVertices(const torch::Tensor& values, const torch::Tensor& ids, torch::Tensor& sums)
{
  const float* from = values.data_ptr<float>();
  const std::int64_t* id = ids.data_ptr<std::int64_t>();
  float* const to = sums.data_ptr<float>();
  for (std::int64_t k = 0; k < ids.numel(); ++k, from += 3)
  {
    float* const row = to + 3 * id[k];
    row[0] += from[0];
    row[1] += from[1];
    row[2] += from[2];
  }
}

void Store(const std::array<Vector, 3>& vectors, float* out)
{
  for (const Vector& vector : vectors)
  {
    out = std::copy_n(vector.data(), 3, out);
  }
}

class EdgeFeatureStep : public torch::autograd::Function<EdgeFeatureStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& positions, const torch::Tensor& triangles,
    const torch::Tensor& opposite, const torch::Tensor& sides)
  {
    const torch::Tensor points = positions.contiguous();
    context->save_for_backward({ points, triangles, opposite, sides });
    const std::int64_t faces = triangles.size(0);
    const torch::Tensor features = torch::empty({ faces, 12 }, torch::kFloat32);
    const float* const at = points.data_ptr<float>();
    const std::int64_t* const corners = triangles.data_ptr<std::int64_t>();
    const std::int64_t* const beyond = opposite.data_ptr<std::int64_t>();
    const float* const side = sides.data_ptr<float>();
    float* const to = features.data_ptr<float>();
    ForTriangles(faces, [=](std::int64_t begin, std::int64_t end) {
      for (std::int64_t f = begin; f < end; ++f)
      {
        const TriangleFrames frames(at, corners + 3 * f);
        float* out = to + 12 * f;
        for (std::size_t k = 0; k < 3; ++k, out += 4)
        {
          const std::int64_t edge = 3 * f + static_cast<std::int64_t>(k);
          const Vector offset = side[edge] * (VectorAt(at + 3 * beyond[edge]) - frames.Midpoint(k));
          out[0] = offset.dot(frames.Along[k].Unit);
          out[1] = offset.dot(frames.Outward(k));
          out[2] = offset.dot(frames.Normal.Unit);
          out[3] = frames.Along[k].Length;
        }
      }
    });
    return features;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RefuseSecondFrameDerivatives();
    const variable_list saved = context->get_saved_variables();
    const torch::Tensor gradient = gradients[0].contiguous();
    const std::int64_t faces = saved[1].size(0);
    const torch::Tensor byCorners = torch::empty({ faces, 3, 3 }, torch::kFloat32);
    const torch::Tensor byOpposite = torch::empty({ faces, 3, 3 }, torch::kFloat32);
    const float* const at = saved[0].data_ptr<float>();
    const std::int64_t* const corners = saved[1].data_ptr<std::int64_t>();
    const std::int64_t* const beyond = saved[2].data_ptr<std::int64_t>();
    const float* const side = saved[3].data_ptr<float>();
    const float* const from = gradient.data_ptr<float>();
    float* const toCorners = byCorners.data_ptr<float>();
    float* const toOpposite = byOpposite.data_ptr<float>();
    ForTriangles(faces, [=](std::int64_t begin, std::int64_t end) {
      for (std::int64_t f = begin; f < end; ++f)
      {
        const FrameDerivatives out = OfTriangle(at, corners + 3 * f, beyond + 3 * f, side + 3 * f, from + 12 * f);
        Store(out.Corner, toCorners + 9 * f);
        Store(out.Opposite, toOpposite + 9 * f);
      }
    });
    torch::Tensor byPositions = torch::zeros_like(saved[0]);
    AddToVertices(byCorners, saved[1], byPositions);
    AddToVertices(byOpposite, saved[2], byPositions);
    return { byPositions, {}, {}, {} };
  }

private:
  static FrameDerivatives OfTriangle(const float* positions, const std::int64_t* triangle, const std::int64_t* opposite,
    const float* side, const float* gradient)
  {
    const TriangleFrames frames(positions, triangle);
    FrameDerivatives out;
    for (std::size_t k = 0; k < 3; ++k, gradient += 4)
    {
      const Vector offset = side[k] * (VectorAt(positions + 3 * opposite[k]) - frames.Midpoint(k));
      const Vector byOffset = side[k] *
        (gradient[0] * frames.Along[k].Unit + gradient[1] * frames.Outward(k) + gradient[2] * frames.Normal.Unit);
      out.Opposite[k] = byOffset;
      out.Corner[k] -= 0.5F * byOffset;
      out.Corner[(k + 1) % 3] -= 0.5F * byOffset;
      out.Along[k] += gradient[0] * offset;
      out.AddOutward(frames, k, gradient[1] * offset);
      out.Normal += gradient[2] * offset;
      out.Length[k] = gradient[3];
    }
    out.Finish(frames);
    return out;
  }
};

class CornerDisplacementStep : public torch::autograd::Function<CornerDisplacementStep>
{
public:
  static torch::Tensor forward(AutogradContext* context, const torch::Tensor& positions, const torch::Tensor& local,
    const torch::Tensor& triangles, const torch::Tensor& counts)
  {
    const torch::Tensor points = positions.contiguous();
    const torch::Tensor weights = local.contiguous();
    context->save_for_backward({ points, weights, triangles, counts });
    const std::int64_t faces = triangles.size(0);
    const torch::Tensor moved = torch::empty({ faces, 3, 3 }, torch::kFloat32);
    const float* const at = points.data_ptr<float>();
    const float* const weight = weights.data_ptr<float>();
    const std::int64_t* const corners = triangles.data_ptr<std::int64_t>();
    float* const to = moved.data_ptr<float>();
    ForTriangles(faces, [=](std::int64_t begin, std::int64_t end) {
      for (std::int64_t f = begin; f < end; ++f)
      {
        const TriangleFrames frames(at, corners + 3 * f);
        const float* const abc = weight + 3 * f;
        std::array<Vector, 3> out;
        for (std::size_t k = 0; k < 3; ++k)
        {
          out[k] = abc[0] * frames.Along[k].Unit + abc[1] * frames.Outward(k) + abc[2] * frames.Normal.Unit;
        }
        Store(out, to + 9 * f);
      }
    });
    torch::Tensor sums = torch::zeros_like(points);
    AddToVertices(moved, triangles, sums);
    return sums.div_(counts);
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients)
  {
    RefuseSecondFrameDerivatives();
    const variable_list saved = context->get_saved_variables();
    const torch::Tensor gradient = (gradients[0] / saved[3]).contiguous();
    const std::int64_t faces = saved[2].size(0);
    const torch::Tensor byCorners = torch::empty({ faces, 3, 3 }, torch::kFloat32);
    const torch::Tensor byLocal = torch::empty_like(saved[1]);
    const float* const at = saved[0].data_ptr<float>();
    const float* const weights = saved[1].data_ptr<float>();
    const std::int64_t* const corners = saved[2].data_ptr<std::int64_t>();
    const float* const from = gradient.data_ptr<float>();
    float* const toCorners = byCorners.data_ptr<float>();
    float* const toLocal = byLocal.data_ptr<float>();
    ForTriangles(faces, [=](std::int64_t begin, std::int64_t end) {
      for (std::int64_t f = begin; f < end; ++f)
      {
        const FrameDerivatives out = OfTriangle(at, corners + 3 * f, weights + 3 * f, from, toLocal + 3 * f);
        Store(out.Corner, toCorners + 9 * f);
      }
    });
    torch::Tensor byPositions = torch::zeros_like(saved[0]);
    AddToVertices(byCorners, saved[2], byPositions);
    return { byPositions, byLocal, {}, {} };
  }

private:
  /// @param gradient of the vertices, over their numbers of triangles
  static FrameDerivatives OfTriangle(
    const float* positions, const std::int64_t* triangle, const float* abc, const float* gradient, float* byLocal)
  {
    const TriangleFrames frames(positions, triangle);
    FrameDerivatives out;
    Vector sums = Vector::Zero();
    for (std::size_t k = 0; k < 3; ++k)
    {
      const Vector w = VectorAt(gradient + 3 * triangle[k]);
      sums += Vector(w.dot(frames.Along[k].Unit), w.dot(frames.Outward(k)), w.dot(frames.Normal.Unit));
      out.Along[k] = abc[0] * w;
      out.AddOutward(frames, k, abc[1] * w);
      out.Normal += abc[2] * w;
    }
    std::copy_n(sums.data(), 3, byLocal);
    out.Finish(frames);
    return out;
  }
};
} // namespace

torch::Tensor FusedEdgeFeatures(const FaceTables& tables, const torch::Tensor& positions)
{
  return EdgeFeatureStep::apply(positions, tables.Triangles, tables.Opposite, tables.Sides);
}

torch::Tensor FusedCornerDisplacement(
  const FaceTables& tables, const torch::Tensor& positions, const torch::Tensor& local)
{
  return CornerDisplacementStep::apply(positions, local, tables.Triangles, tables.Corners);
}

} // namespace surfsynth
