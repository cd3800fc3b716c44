// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Groups of MPI ranks that work together, without MPI's own header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace surfsynth
{

/// MPI ranks that call the same functions in the same order. Copies share one communicator, of which they are the only
/// users.
///
/// All functions but Rank(), Count() and WorldRank() are collective: no rank may leave a call out. Memory that runs out
/// in one of them ends the job, since the other ranks wait.
class RankGroup
{
public:
  /// All ranks of the job. Initializes MPI where the program has not, and finalizes it at the end of the program then.
  static RankGroup World();
  /// The ranks with these numbers in World(), in this order; only they call.
  /// @throws InvalidInput when the numbers repeat, as those of ranks of several jobs do.
  static RankGroup OfWorldRanks(const std::vector<int>& ranks);
  /// Number of this process in World(); -1 when the program has not initialized MPI.
  static int WorldRank();

  int Rank() const;  ///< of this process, from 0
  int Count() const; ///< number of ranks, at least 1
  /// The communicator, for those who include MPI: a pointer to an MPI_Comm.
  const void* Communicator() const;

  /// Calls @p work on every rank and throws on all of them when it throws on one: the error of the lowest such rank, whose
  /// number its text begins with where there are several.
  /// @throws InvalidInput, SolverFailure, Cancelled and FormatError as @p work does; SolverFailure for what is no Error.
  void Together(const std::function<void()>& work) const;

  /// Returns the items of all ranks, in the order of ranks.
  template <typename T>
  std::vector<T> GatherAll(const std::vector<T>& items) const;
  /// Sends items[r] to rank r; returns the items that each rank has sent here.
  template <typename T>
  std::vector<std::vector<T>> Exchange(const std::vector<std::vector<T>>& items) const;
  /// Sends each query to a rank, which answers it; returns the replies in the order of the queries.
  /// @param destinations rank for each query
  /// @param answer takes the queries that came from each rank, and returns as many replies for each
  template <typename Reply, typename Query, typename Answer>
  std::vector<Reply> Ask(
    const std::vector<Query>& queries, const std::vector<int>& destinations, const Answer& answer) const;

  double Sum(double value) const;          ///< over ranks, in their order
  double Maximum(double value) const;      ///< over ranks
  std::int64_t Total(std::int64_t) const;  ///< over ranks
  std::int64_t Before(std::int64_t) const; ///< over the ranks before this one

private:
  struct Handle;
  explicit RankGroup(std::shared_ptr<const Handle> handle)
    : Shared(std::move(handle))
  {}

  std::vector<std::int64_t> ExchangeCounts(const std::vector<std::int64_t>& counts) const;
  void ExchangeItems(const void* sent, const std::vector<std::int64_t>& sentCounts, void* received,
    const std::vector<std::int64_t>& receivedCounts, std::size_t itemSize) const;

  std::shared_ptr<const Handle> Shared;
};

template <typename T>
std::vector<std::vector<T>> RankGroup::Exchange(const std::vector<std::vector<T>>& items) const
{
  std::vector<std::int64_t> counts;
  std::vector<T> sent;
  for (const auto& ofRank : items)
  {
    counts.push_back(static_cast<std::int64_t>(ofRank.size()));
    sent.insert(sent.end(), ofRank.begin(), ofRank.end());
  }
  const std::vector<std::int64_t> receivedCounts = this->ExchangeCounts(counts);
  std::size_t total = 0;
  for (const std::int64_t count : receivedCounts)
  {
    total += static_cast<std::size_t>(count);
  }
  std::vector<T> received(total);
  this->ExchangeItems(sent.data(), counts, received.data(), receivedCounts, sizeof(T));
  std::vector<std::vector<T>> result;
  auto next = received.begin();
  for (const std::int64_t count : receivedCounts)
  {
    result.emplace_back(next, next + count);
    next += count;
  }
  return result;
}

template <typename T>
std::vector<T> RankGroup::GatherAll(const std::vector<T>& items) const
{
  std::vector<T> all;
  for (const auto& ofRank : this->Exchange(std::vector<std::vector<T>>(static_cast<std::size_t>(this->Count()), items)))
  {
    all.insert(all.end(), ofRank.begin(), ofRank.end());
  }
  return all;
}

template <typename Reply, typename Query, typename Answer>
std::vector<Reply> RankGroup::Ask(
  const std::vector<Query>& queries, const std::vector<int>& destinations, const Answer& answer) const
{
  std::vector<std::vector<Query>> toRank(static_cast<std::size_t>(this->Count()));
  for (std::size_t k = 0; k < queries.size(); ++k)
  {
    toRank[static_cast<std::size_t>(destinations[k])].push_back(queries[k]);
  }
  std::vector<std::vector<Query>> received = this->Exchange(toRank);
  toRank = {};
  const std::vector<std::vector<Reply>> sent = answer(received);
  received = {};
  const std::vector<std::vector<Reply>> replies = this->Exchange(sent);
  std::vector<std::size_t> next(static_cast<std::size_t>(this->Count()), 0);
  std::vector<Reply> inOrder;
  inOrder.reserve(queries.size());
  for (const int rank : destinations)
  {
    inOrder.push_back(replies[static_cast<std::size_t>(rank)][next[static_cast<std::size_t>(rank)]++]);
  }
  return inOrder;
}

} // namespace surfsynth
