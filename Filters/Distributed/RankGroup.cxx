// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/RankGroup.h"

#include "Core/Common/Errors.h"

#include <mpi.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <limits>
#include <numeric>
#include <set>
#include <string>

namespace surfsynth
{

struct RankGroup::Handle
{
  explicit Handle(MPI_Comm communicator)
    : Communicator(communicator)
  {
    MPI_Comm_rank(communicator, &this->Rank);
    MPI_Comm_size(communicator, &this->Count);
  }
  ~Handle()
  {
    int finalized = 0;
    MPI_Finalized(&finalized);
    if (!finalized)
    {
      MPI_Comm_free(&this->Communicator);
    }
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  MPI_Comm Communicator;
  int Rank = 0;
  int Count = 1;
};

namespace
{
bool IsInitialized()
{
  int initialized = 0;
  MPI_Initialized(&initialized);
  return initialized != 0;
}

/// Ends what World() has begun.
void FinalizeMpi()
{
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (!finalized)
  {
    MPI_Finalize();
  }
}

enum class Failure : std::int64_t
{
  None,
  Input,
  Solver,
  Format,
  Stop
};

/// Calls @p work and returns the kind of what it throws, with its text.
Failure Attempt(const std::function<void()>& work, std::string& text)
{
  try
  {
    work();
    return Failure::None;
  }
  catch (const InvalidInput& error)
  {
    text = error.what();
    return Failure::Input;
  }
  catch (const FormatError& error)
  {
    text = error.what();
    return Failure::Format;
  }
  catch (const Cancelled& error)
  {
    text = error.what();
    return Failure::Stop;
  }
  catch (const std::bad_alloc&)
  {
    text = "There is not enough memory.";
  }
  catch (const std::exception& error)
  {
    text = error.what();
  }
  catch (...)
  {
    text = "An error of unknown type was thrown.";
  }
  return Failure::Solver;
}

[[noreturn]] void Throw(Failure failure, const std::string& text)
{
  switch (failure)
  {
    case Failure::Input:
      throw InvalidInput(text);
    case Failure::Format:
      throw FormatError(text);
    case Failure::Stop:
      throw Cancelled(text);
    default:
      throw SolverFailure(text);
  }
}

/// Counts and offsets as MPI takes them.
struct Layout
{
  explicit Layout(const std::vector<std::int64_t>& counts)
  {
    std::int64_t offset = 0;
    for (const std::int64_t count : counts)
    {
      this->Counts.push_back(static_cast<int>(count));
      this->Offsets.push_back(static_cast<int>(offset));
      offset += count;
    }
    this->Fits = offset <= std::numeric_limits<int>::max();
  }

  std::vector<int> Counts;
  std::vector<int> Offsets;
  bool Fits = true;
};
} // namespace

RankGroup RankGroup::World()
{
  if (!IsInitialized())
  {
    MPI_Init(nullptr, nullptr);
    std::atexit(FinalizeMpi);
  }
  MPI_Comm own = MPI_COMM_NULL;
  MPI_Comm_dup(MPI_COMM_WORLD, &own);
  return RankGroup(std::make_shared<const Handle>(own));
}

RankGroup RankGroup::OfWorldRanks(const std::vector<int>& ranks)
{
  const std::set<int> distinct(ranks.begin(), ranks.end());
  if (!IsInitialized() || distinct.size() != ranks.size() || (!distinct.empty() && *distinct.begin() < 0))
  {
    throw InvalidInput("RankGroup: the processes of the pipeline are not ranks of one MPI job; expected those that one "
                       "mpiexec has started.");
  }
  constexpr int Tag = 7361;
  MPI_Group world = MPI_GROUP_NULL;
  MPI_Group members = MPI_GROUP_NULL;
  MPI_Comm own = MPI_COMM_NULL;
  MPI_Comm_group(MPI_COMM_WORLD, &world);
  MPI_Group_incl(world, static_cast<int>(ranks.size()), ranks.data(), &members);
  MPI_Comm_create_group(MPI_COMM_WORLD, members, Tag, &own);
  MPI_Group_free(&members);
  MPI_Group_free(&world);
  return RankGroup(std::make_shared<const Handle>(own));
}

int RankGroup::WorldRank()
{
  int rank = -1;
  if (IsInitialized())
  {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  }
  return rank;
}

int RankGroup::Rank() const { return this->Shared->Rank; }

int RankGroup::Count() const { return this->Shared->Count; }

const void* RankGroup::Communicator() const { return &this->Shared->Communicator; }

void RankGroup::Together(const std::function<void()>& work) const
{
  std::string text;
  const Failure failure = Attempt(work, text);
  const auto failures = this->GatherAll(std::vector<std::int64_t>{ static_cast<std::int64_t>(failure) });
  const auto first = std::find_if(failures.begin(), failures.end(), [](std::int64_t kind) { return kind != 0; });
  if (first == failures.end())
  {
    return;
  }
  const bool isFirst = first - failures.begin() == this->Rank();
  const auto letters = this->GatherAll(isFirst ? std::vector<char>(text.begin(), text.end()) : std::vector<char>());
  const std::string prefix = this->Count() > 1 ? "Rank " + std::to_string(first - failures.begin()) + ": " : "";
  Throw(static_cast<Failure>(*first), prefix + std::string(letters.begin(), letters.end()));
}

std::vector<std::int64_t> RankGroup::ExchangeCounts(const std::vector<std::int64_t>& counts) const
{
  std::vector<std::int64_t> received(counts.size());
  MPI_Alltoall(counts.data(), 1, MPI_INT64_T, received.data(), 1, MPI_INT64_T, this->Shared->Communicator);
  return received;
}

void RankGroup::ExchangeItems(const void* sent, const std::vector<std::int64_t>& sentCounts, void* received,
  const std::vector<std::int64_t>& receivedCounts, std::size_t itemSize) const
{
  const Layout from(sentCounts);
  const Layout to(receivedCounts);
  int fits = from.Fits && to.Fits ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &fits, 1, MPI_INT, MPI_MIN, this->Shared->Communicator);
  if (!fits)
  {
    throw InvalidInput(
      "RankGroup: a rank has more than 2147483647 items to send or to receive; expected fewer, on more "
      "ranks.");
  }
  MPI_Datatype item = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(itemSize), MPI_BYTE, &item);
  MPI_Type_commit(&item);
  MPI_Alltoallv(sent, from.Counts.data(), from.Offsets.data(), item, received, to.Counts.data(), to.Offsets.data(),
    item, this->Shared->Communicator);
  MPI_Type_free(&item);
}

double RankGroup::Sum(double value) const
{
  const std::vector<double> all = this->GatherAll(std::vector<double>{ value });
  return std::accumulate(all.begin(), all.end(), 0.0);
}

double RankGroup::Maximum(double value) const
{
  const std::vector<double> all = this->GatherAll(std::vector<double>{ value });
  return *std::max_element(all.begin(), all.end());
}

std::int64_t RankGroup::Total(std::int64_t value) const
{
  const auto all = this->GatherAll(std::vector<std::int64_t>{ value });
  return std::accumulate(all.begin(), all.end(), std::int64_t(0));
}

std::int64_t RankGroup::Before(std::int64_t value) const
{
  const auto all = this->GatherAll(std::vector<std::int64_t>{ value });
  return std::accumulate(all.begin(), all.begin() + this->Rank(), std::int64_t(0));
}

} // namespace surfsynth
