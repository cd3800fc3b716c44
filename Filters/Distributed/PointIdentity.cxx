// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/PointIdentity.h"

#include "Core/Random/PlaceHash.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace surfsynth
{

namespace
{
using Coordinates = std::array<double, 3>;

Coordinates PointOf(const PointMatrix& points, Eigen::Index k) { return { points(k, 0), points(k, 1), points(k, 2) }; }

struct IdQuery
{
  std::int64_t Id;
  Coordinates Point;
};

struct IdReply
{
  std::int64_t WholeId;
  Coordinates Point;
  std::int64_t Shared;
};

struct PlaceQuery
{
  Coordinates Point;
  std::int64_t Number; ///< in the piece
};

struct PlaceReply
{
  std::int64_t Rank;   ///< lowest that holds the point
  std::int64_t Number; ///< in its piece
  std::int64_t Shared;
};

/// Place of a query among those that a rank has received.
struct Place
{
  std::size_t Rank;
  std::size_t Entry;
};

/// Places of all queries, in the order of @p less, of ranks and of entries.
template <typename Query, typename Less>
std::vector<Place> Sorted(const std::vector<std::vector<Query>>& received, const Less& less)
{
  std::vector<Place> places;
  for (std::size_t rank = 0; rank < received.size(); ++rank)
  {
    for (std::size_t entry = 0; entry < received[rank].size(); ++entry)
    {
      places.push_back({ rank, entry });
    }
  }
  const auto at = [&received](const Place& place) -> const Query& { return received[place.Rank][place.Entry]; };
  std::stable_sort(places.begin(), places.end(), [&](const Place& a, const Place& b) { return less(at(a), at(b)); });
  return places;
}

/// Calls visit(first, last) for each range of equal queries.
template <typename Query, typename Less, typename Visit>
void EachGroup(const std::vector<std::vector<Query>>& received, const std::vector<Place>& places, const Less& less,
  const Visit& visit)
{
  const auto at = [&](std::size_t k) -> const Query& { return received[places[k].Rank][places[k].Entry]; };
  for (std::size_t first = 0; first < places.size();)
  {
    std::size_t last = first + 1;
    while (last < places.size() && !less(at(first), at(last)))
    {
      ++last;
    }
    visit(first, last);
    first = last;
  }
}

template <typename Reply, typename Query>
std::vector<std::vector<Reply>> RepliesFor(const std::vector<std::vector<Query>>& received)
{
  std::vector<std::vector<Reply>> replies;
  for (const auto& queries : received)
  {
    replies.emplace_back(queries.size());
  }
  return replies;
}

/// Homes of ids that follow each other are ranks that follow each other, so that ids are numbered in their order.
std::vector<int> HomesOfIds(const RankGroup& ranks, const std::vector<std::int64_t>& ids)
{
  const auto bounds = std::minmax_element(ids.begin(), ids.end());
  std::vector<std::int64_t> mine;
  if (!ids.empty())
  {
    mine = { *bounds.first, *bounds.second };
  }
  const std::vector<std::int64_t> all = ranks.GatherAll(mine);
  const std::int64_t lowest = all.empty() ? 0 : *std::min_element(all.begin(), all.end());
  const double width = all.empty()
    ? 1.0
    : static_cast<double>(*std::max_element(all.begin(), all.end())) - static_cast<double>(lowest) + 1.0;
  std::vector<int> homes;
  for (const std::int64_t id : ids)
  {
    const double share = (static_cast<double>(id) - static_cast<double>(lowest)) / width;
    homes.push_back(std::clamp(static_cast<int>(share * ranks.Count()), 0, ranks.Count() - 1));
  }
  return homes;
}

PointIdentity IdentifyByIds(const RankGroup& ranks, const PointMatrix& points, const std::vector<std::int64_t>& ids)
{
  std::vector<IdQuery> queries;
  for (std::size_t k = 0; k < ids.size(); ++k)
  {
    queries.push_back({ ids[k], PointOf(points, static_cast<Eigen::Index>(k)) });
  }
  const auto less = [](const IdQuery& a, const IdQuery& b) { return a.Id < b.Id; };
  PointIdentity identity;
  const auto answer = [&](const std::vector<std::vector<IdQuery>>& received) {
    auto replies = RepliesFor<IdReply>(received);
    const std::vector<Place> places = Sorted(received, less);
    std::int64_t distinct = 0;
    EachGroup(received, places, less, [&](std::size_t, std::size_t) { ++distinct; });
    std::int64_t next = ranks.Before(distinct);
    identity.NumberOfWholePoints = ranks.Total(distinct);
    EachGroup(received, places, less, [&](std::size_t first, std::size_t last) {
      const bool shared = last - first > 1;
      const Coordinates point = received[places[first].Rank][places[first].Entry].Point;
      for (std::size_t k = first; k < last; ++k)
      {
        replies[places[k].Rank][places[k].Entry] = { next, point, shared ? 1 : 0 };
      }
      ++next;
    });
    return replies;
  };
  const auto replies = ranks.Ask<IdReply>(queries, HomesOfIds(ranks, ids), answer);
  identity.Points.resize(points.rows(), 3);
  for (std::size_t k = 0; k < replies.size(); ++k)
  {
    identity.WholeIds.push_back(replies[k].WholeId);
    identity.Shared.push_back(replies[k].Shared != 0);
    identity.Points.row(static_cast<Eigen::Index>(k)) << replies[k].Point[0], replies[k].Point[1], replies[k].Point[2];
  }
  return identity;
}

int HomeOfPlace(const Coordinates& point, int count)
{
  std::array<std::uint64_t, 3> bits;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double value = point[k] + 0.0; // -0 and 0 are equal
    std::memcpy(&bits[k], &value, sizeof(value));
  }
  return static_cast<int>(HashOfPlace(bits) % static_cast<std::uint64_t>(count));
}

std::vector<std::vector<PlaceReply>> AnswerPlaces(const std::vector<std::vector<PlaceQuery>>& received)
{
  const auto less = [](const PlaceQuery& a, const PlaceQuery& b) { return a.Point < b.Point; };
  auto replies = RepliesFor<PlaceReply>(received);
  const std::vector<Place> places = Sorted(received, less);
  EachGroup(received, places, less, [&](std::size_t first, std::size_t last) {
    const std::size_t lowest = places[first].Rank;
    const PlaceReply shared{ static_cast<std::int64_t>(lowest), received[lowest][places[first].Entry].Number,
      places[last - 1].Rank != lowest ? 1 : 0 };
    for (std::size_t k = first; k < last; ++k)
    {
      // Points of one piece are different points; those of later pieces are the first one.
      const PlaceQuery& query = received[places[k].Rank][places[k].Entry];
      const bool isOther = places[k].Rank == lowest && k > first;
      replies[places[k].Rank][places[k].Entry] = !isOther
        ? shared
        : PlaceReply{ static_cast<std::int64_t>(lowest), query.Number, 0 };
    }
  });
  return replies;
}

/// Asks the ranks that hold points first for their numbers in the whole.
void TakeIdsOfOthers(const RankGroup& ranks, const std::vector<PlaceReply>& first, std::vector<std::int64_t>& wholeIds)
{
  std::vector<std::size_t> points;
  std::vector<std::int64_t> numbers;
  std::vector<int> owners;
  for (std::size_t k = 0; k < first.size(); ++k)
  {
    if (first[k].Rank != ranks.Rank())
    {
      points.push_back(k);
      numbers.push_back(first[k].Number);
      owners.push_back(static_cast<int>(first[k].Rank));
    }
  }
  const auto answer = [&](std::vector<std::vector<std::int64_t>> received) {
    for (auto& ofRank : received)
    {
      std::transform(ofRank.begin(), ofRank.end(), ofRank.begin(),
        [&](std::int64_t number) { return wholeIds[static_cast<std::size_t>(number)]; });
    }
    return received;
  };
  const auto replies = ranks.Ask<std::int64_t>(numbers, owners, answer);
  for (std::size_t k = 0; k < points.size(); ++k)
  {
    wholeIds[points[k]] = replies[k];
  }
}

PointIdentity IdentifyByCoordinates(const RankGroup& ranks, const PointMatrix& points)
{
  std::vector<PlaceQuery> queries;
  std::vector<int> homes;
  for (Eigen::Index k = 0; k < points.rows(); ++k)
  {
    const Coordinates point = PointOf(points, k);
    if (std::none_of(point.begin(), point.end(), [](double value) { return std::isnan(value); }))
    {
      queries.push_back({ point, k });
      homes.push_back(HomeOfPlace(point, ranks.Count()));
    }
  }
  const auto replies = ranks.Ask<PlaceReply>(queries, homes, AnswerPlaces);
  std::vector<PlaceReply> first;
  for (Eigen::Index k = 0; k < points.rows(); ++k)
  {
    first.push_back({ ranks.Rank(), k, 0 }); // what holds for NaN
  }
  for (std::size_t k = 0; k < queries.size(); ++k)
  {
    first[static_cast<std::size_t>(queries[k].Number)] = replies[k];
  }
  const std::int64_t own = std::count_if(
    first.begin(), first.end(), [&](const PlaceReply& place) { return place.Rank == ranks.Rank(); });
  std::int64_t next = ranks.Before(own);
  PointIdentity identity;
  for (const PlaceReply& place : first)
  {
    identity.WholeIds.push_back(place.Rank == ranks.Rank() ? next++ : -1);
    identity.Shared.push_back(place.Shared != 0);
  }
  TakeIdsOfOthers(ranks, first, identity.WholeIds);
  identity.Points = points;
  identity.NumberOfWholePoints = ranks.Total(own);
  return identity;
}
} // namespace

PointIdentity IdentifyPoints(
  const RankGroup& ranks, const PointMatrix& points, const std::vector<std::int64_t>& globalIds)
{
  const bool hasIds = static_cast<Eigen::Index>(globalIds.size()) == points.rows();
  const bool allHave = ranks.Total(hasIds ? 0 : 1) == 0;
  return allHave ? IdentifyByIds(ranks, points, globalIds) : IdentifyByCoordinates(ranks, points);
}

} // namespace surfsynth
