// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Solvers/MinimumDegree.h"

#include <algorithm>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr Index WordBits = 64;

std::uint64_t Bit(Index number) { return std::uint64_t(1) << (number % WordBits); }
} // namespace

void MinimumDegree::Begin(Index own, Index halo)
{
  this->Own = own;
  this->Words = (own + halo + WordBits - 1) / WordBits;
  this->Bits.assign(static_cast<std::size_t>(own) * static_cast<std::size_t>(this->Words), 0);
  this->Degrees.assign(static_cast<std::size_t>(own), 0);
}

void MinimumDegree::Connect(Index vertex, Index other)
{
  std::uint64_t& word = this->Bits[std::size_t(vertex) * this->Words + other / WordBits];
  this->Degrees[vertex] += (word & Bit(other)) == 0;
  word |= Bit(other);
}

const std::vector<Index>& MinimumDegree::Order()
{
  this->Result.clear();
  for (Index k = 0; k < this->Own; ++k)
  {
    const auto least = std::min_element(this->Degrees.begin(), this->Degrees.end());
    const auto vertex = static_cast<Index>(least - this->Degrees.begin());
    this->Result.push_back(vertex);
    *least = std::numeric_limits<Index>::max();
    this->Eliminate(vertex);
  }
  return this->Result;
}

void MinimumDegree::Eliminate(Index vertex)
{
  const std::uint64_t* row = this->Bits.data() + std::size_t(vertex) * this->Words;
  for (Index word = 0; word * WordBits < this->Own; ++word)
  {
    for (std::uint64_t rest = row[word]; rest != 0; rest &= rest - 1)
    {
      const Index neighbor = word * WordBits + __builtin_ctzll(rest);
      if (neighbor >= this->Own)
      {
        break;
      }
      std::uint64_t* other = this->Bits.data() + std::size_t(neighbor) * this->Words;
      for (Index w = 0; w < this->Words; ++w)
      {
        other[w] |= row[w];
      }
      other[neighbor / WordBits] &= ~Bit(neighbor);
      other[vertex / WordBits] &= ~Bit(vertex);
      Index degree = 0;
      for (Index w = 0; w < this->Words; ++w)
      {
        degree += __builtin_popcountll(other[w]);
      }
      this->Degrees[neighbor] = degree;
    }
  }
}

} // namespace surfsynth
