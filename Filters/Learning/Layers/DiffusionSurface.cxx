// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Layers/DiffusionSurface.h"

#include "Inference/FieldLatents/LatentDiffusionKernels.h"

#include <algorithm>
#include <utility>

namespace surfsynth
{

namespace
{
/// Rows of the embeddings: 0 for a vertex without a label.
std::vector<std::int32_t> RowsOf(const std::vector<std::int32_t>& labels)
{
  std::vector<std::int32_t> rows(labels.size());
  std::transform(
    labels.begin(), labels.end(), rows.begin(), [](std::int32_t label) { return std::max(label, -1) + 1; });
  return rows;
}

/// Values at the centers of the clusters; empty when there are none.
std::vector<std::int32_t> AtCenters(const TangentHierarchy& surface, const std::vector<std::int32_t>& values)
{
  std::vector<std::int32_t> chosen;
  for (std::size_t a = 0; !values.empty() && a < surface.Centers.size(); ++a)
  {
    chosen.push_back(values[static_cast<std::size_t>(surface.Centers[a])]);
  }
  return chosen;
}

FieldLatentMatrix AtCenters(const TangentHierarchy& surface, const FieldLatentMatrix& values)
{
  if (values.size() == 0)
  {
    return {};
  }
  FieldLatentMatrix chosen(static_cast<Eigen::Index>(surface.Centers.size()), values.cols());
  for (std::size_t a = 0; a < surface.Centers.size(); ++a)
  {
    chosen.row(static_cast<Eigen::Index>(a)) = values.row(surface.Centers[a]);
  }
  return chosen;
}
} // namespace

FieldLevel::FieldLevel(TangentNeighborhoods neighborhoods, std::vector<std::int32_t> rows, FieldLatentMatrix directions)
  : Neighborhoods(std::move(neighborhoods))
  , Rows(std::move(rows))
  , Directions(std::move(directions))
{
  const TangentNeighborhoods& at = this->Neighborhoods;
  this->SourceStart.assign(static_cast<std::size_t>(at.NumberOfVertices()) + 1, 0);
  this->SourceEdges.resize(at.Sources.size());
  this->SourceTargets.resize(at.Sources.size());
  for (const Index q : at.Sources)
  {
    ++this->SourceStart[static_cast<std::size_t>(q) + 1];
  }
  for (std::size_t v = 1; v < this->SourceStart.size(); ++v)
  {
    this->SourceStart[v] += this->SourceStart[v - 1];
  }
  std::vector<std::int32_t> next(this->SourceStart.begin(), this->SourceStart.end() - 1);
  for (Index p = 0; p < at.NumberOfVertices(); ++p)
  {
    for (Index e = at.Start[static_cast<std::size_t>(p)]; e < at.Start[static_cast<std::size_t>(p) + 1]; ++e)
    {
      const Index q = at.Sources[static_cast<std::size_t>(e)];
      const auto place = static_cast<std::size_t>(next[static_cast<std::size_t>(q)]++);
      this->SourceEdges[place] = e;
      this->SourceTargets[place] = p;
    }
  }
}

FieldNeighborhoods FieldLevel::View(bool guided) const
{
  // std::complex<float> has the layout of two numbers.
  const TangentNeighborhoods& at = this->Neighborhoods;
  return { at.Start.data(), at.Sources.data(), reinterpret_cast<const float*>(at.Logarithms.data()),
    reinterpret_cast<const float*>(at.Transport.data()), at.Weights.data(),
    reinterpret_cast<const float*>(at.Centroids.data()),
    guided && this->Directions.size() > 0 ? this->Directions.data() : nullptr,
    guided && !this->Rows.empty() ? this->Rows.data() : nullptr };
}

FieldSources FieldLevel::Sources() const
{
  return { this->SourceStart.data(), this->SourceEdges.data(), this->SourceTargets.data() };
}

DiffusionSurface::DiffusionSurface(const TangentHierarchy& surface, const LatentDiffusionConditions& conditions)
  : Fine(surface.Fine, RowsOf(conditions.Labels), conditions.Directions)
  , Coarse(surface.Coarse, AtCenters(surface, RowsOf(conditions.Labels)), AtCenters(surface, conditions.Directions))
  , Clusters(surface.Clusters)
  , ToCenter(surface.ToCenter)
  , MemberStart(surface.MemberStart)
  , Members(surface.Members)
{}

} // namespace surfsynth
