// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/VertexOwners.h"

#include <array>
#include <unordered_map>

namespace surfsynth
{

namespace
{
struct VertexQuery
{
  std::int64_t WholeId;
  std::int64_t Vertex;
  std::int64_t Component; ///< -1 where the rank does not use the vertex
};

struct VertexReply
{
  std::int64_t Rank;
  std::int64_t Vertex;
  std::int64_t Component;
};

/// For each vertex, the lowest rank that uses it; where none does, the lowest that has it.
std::vector<std::vector<VertexReply>> AnswerVertices(const std::vector<std::vector<VertexQuery>>& received)
{
  std::unordered_map<std::int64_t, VertexReply> owners;
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    for (const VertexQuery& query : received[rank])
    {
      const VertexReply here{ static_cast<std::int64_t>(rank), query.Vertex, query.Component };
      const auto entry = owners.emplace(query.WholeId, here);
      if (entry.first->second.Component < 0 && query.Component >= 0)
      {
        entry.first->second = here;
      }
    }
  }
  std::vector<std::vector<VertexReply>> replies;
  for (const auto& queries : received)
  {
    replies.emplace_back();
    for (const VertexQuery& query : queries)
    {
      replies.back().push_back(owners.at(query.WholeId));
    }
  }
  return replies;
}
} // namespace

VertexOwners::VertexOwners(const RankGroup& ranks, const MergedPiece& piece, const std::vector<Index>& components)
  : Ranks(ranks)
{
  this->ChooseOwners(piece, components);
  this->NumberRows();
}

void VertexOwners::ChooseOwners(const MergedPiece& piece, const std::vector<Index>& components)
{
  const Index vertices = piece.Mesh.NumberOfPoints();
  std::vector<VertexQuery> queries;
  std::vector<int> homes;
  for (Index v = 0; v < vertices; ++v)
  {
    this->Owners.push_back(this->Ranks.Rank());
    this->NumbersThere.push_back(v);
    this->OwnerComponents.push_back(components[static_cast<std::size_t>(v)]);
    if (piece.Shared[static_cast<std::size_t>(v)])
    {
      const std::int64_t id = piece.WholeIds[static_cast<std::size_t>(v)];
      queries.push_back({ id, v, components[static_cast<std::size_t>(v)] });
      homes.push_back(static_cast<int>(id % this->Ranks.Count()));
    }
  }
  const auto replies = this->Ranks.Ask<VertexReply>(queries, homes, AnswerVertices);
  for (std::size_t k = 0; k < queries.size(); ++k)
  {
    const auto v = static_cast<std::size_t>(queries[k].Vertex);
    this->Owners[v] = static_cast<int>(replies[k].Rank);
    this->NumbersThere[v] = replies[k].Vertex;
    this->OwnerComponents[v] = static_cast<Index>(replies[k].Component);
  }
}

void VertexOwners::NumberRows()
{
  const auto vertices = static_cast<Index>(this->Owners.size());
  std::vector<std::vector<std::int64_t>> asked(static_cast<std::size_t>(this->Ranks.Count()));
  this->Borrowed.resize(asked.size());
  for (Index v = 0; v < vertices; ++v)
  {
    if (this->IsOwn(v))
    {
      this->OwnVertices.push_back(v);
    }
    else
    {
      const auto owner = static_cast<std::size_t>(this->Owners[static_cast<std::size_t>(v)]);
      this->Borrowed[owner].push_back(v);
      asked[owner].push_back(this->NumbersThere[static_cast<std::size_t>(v)]);
    }
  }
  const auto own = static_cast<std::int64_t>(this->OwnVertices.size());
  this->FirstRow = this->Ranks.Before(own);
  this->NumberOfRows = this->Ranks.Total(own);
  this->Rows.assign(this->Owners.size(), -1);
  for (std::size_t k = 0; k < this->OwnVertices.size(); ++k)
  {
    this->Rows[static_cast<std::size_t>(this->OwnVertices[k])] = this->FirstRow + static_cast<std::int64_t>(k);
  }
  auto rows = this->Ranks.Exchange(asked);
  for (auto& ofRank : rows)
  {
    this->Lent.emplace_back(ofRank.begin(), ofRank.end());
    for (std::int64_t& number : ofRank)
    {
      number = this->Rows[static_cast<std::size_t>(number)];
    }
  }
  const auto replies = this->Ranks.Exchange(rows);
  for (std::size_t rank = 0; rank < replies.size(); ++rank)
  {
    for (std::size_t k = 0; k < replies[rank].size(); ++k)
    {
      this->Rows[static_cast<std::size_t>(this->Borrowed[rank][k])] = replies[rank][k];
    }
  }
  this->NumbersThere = {};
}

Eigen::VectorXd VertexOwners::Sum(const Eigen::VectorXd& values) const
{
  std::vector<std::vector<double>> sent;
  for (const auto& vertices : this->Borrowed)
  {
    sent.emplace_back();
    for (const Index v : vertices)
    {
      sent.back().push_back(values[v]);
    }
  }
  const auto received = this->Ranks.Exchange(sent);
  Eigen::VectorXd rows(static_cast<Eigen::Index>(this->OwnVertices.size()));
  for (std::size_t k = 0; k < this->OwnVertices.size(); ++k)
  {
    rows[static_cast<Eigen::Index>(k)] = values[this->OwnVertices[k]];
  }
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    for (std::size_t k = 0; k < received[rank].size(); ++k)
    {
      rows[this->OwnRow(this->Lent[rank][k])] += received[rank][k];
    }
  }
  return rows;
}

Eigen::VectorXd VertexOwners::Spread(const Eigen::VectorXd& rows) const
{
  std::vector<std::vector<double>> sent;
  for (const auto& vertices : this->Lent)
  {
    sent.emplace_back();
    for (const Index v : vertices)
    {
      sent.back().push_back(rows[this->OwnRow(v)]);
    }
  }
  const auto received = this->Ranks.Exchange(sent);
  Eigen::VectorXd values(static_cast<Eigen::Index>(this->Rows.size()));
  for (std::size_t k = 0; k < this->OwnVertices.size(); ++k)
  {
    values[this->OwnVertices[k]] = rows[static_cast<Eigen::Index>(k)];
  }
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    for (std::size_t k = 0; k < received[rank].size(); ++k)
    {
      values[this->Borrowed[rank][k]] = received[rank][k];
    }
  }
  return values;
}

} // namespace surfsynth
