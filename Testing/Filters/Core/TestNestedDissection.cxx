// SPDX-License-Identifier: BSD-3-Clause
#include "ScreenedMatrices.h"

#include "Core/Solvers/CholeskySolver.h"
#include "Core/Solvers/GraphCoarsening.h"
#include "Core/Solvers/GraphPartition.h"
#include "Core/Solvers/MinimumDegree.h"
#include "Core/Solvers/NestedDissection.h"
#include "Core/Solvers/VertexCover.h"
#include "Core/Solvers/WindowedMinimumDegree.h"

#include <Eigen/OrderingMethods>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

using namespace surfsynth;

namespace
{

using Edges = std::vector<std::pair<Index, Index>>;

/// A matrix with ones on the diagonal and at both places of each edge.
SparseMatrix PatternOf(Index size, const Edges& edges)
{
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index v = 0; v < size; ++v)
  {
    entries.emplace_back(v, v, 1.0);
  }
  for (const auto& [a, b] : edges)
  {
    entries.emplace_back(a, b, 1.0);
    entries.emplace_back(b, a, 1.0);
  }
  SparseMatrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end(), [](double first, double) { return first; });
  return matrix;
}

Edges Grid(Index width, Index height)
{
  Edges edges;
  for (Index v = 0; v < width * height; ++v)
  {
    if (v % width + 1 < width)
    {
      edges.emplace_back(v, v + 1);
    }
    if (v + width < width * height)
    {
      edges.emplace_back(v, v + width);
    }
  }
  return edges;
}

Edges Star(Index rays)
{
  Edges edges;
  for (Index v = 1; v <= rays; ++v)
  {
    edges.emplace_back(0, v);
  }
  return edges;
}

/// Edges between random vertices; small numbers have many.
Edges RandomEdges(Index size, int count)
{
  std::mt19937 random(7);
  Edges edges;
  for (int k = 0; k < count; ++k)
  {
    const Index a = static_cast<Index>(random() % static_cast<unsigned>(size));
    const Index b = static_cast<Index>(random() % static_cast<unsigned>(a + 1));
    if (a != b)
    {
      edges.emplace_back(a, b);
    }
  }
  return edges;
}

/// Entries of the factor in the order, those of the diagonal included: the elimination, one vertex after the other.
std::int64_t FactorEntries(const SparseMatrix& matrix, const std::vector<Index>& order)
{
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
  {
    place[order[k]] = static_cast<Index>(k);
  }
  // The pattern of a column is that of the matrix and those of its children in the elimination tree [Chen2008].
  std::vector<std::vector<Index>> below(order.size());
  std::vector<std::vector<Index>> children(order.size());
  std::int64_t entries = 0;
  for (std::size_t k = 0; k < order.size(); ++k)
  {
    std::vector<Index>& column = below[k];
    for (SparseMatrix::InnerIterator entry(matrix, order[k]); entry; ++entry)
    {
      column.push_back(place[entry.row()]);
    }
    for (const Index child : children[k])
    {
      column.insert(column.end(), below[child].begin(), below[child].end());
      std::vector<Index>().swap(below[child]);
    }
    const auto isAbove = [&](Index row) { return row <= static_cast<Index>(k); };
    column.erase(std::remove_if(column.begin(), column.end(), isAbove), column.end());
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    entries += 1 + static_cast<std::int64_t>(column.size());
    if (!column.empty())
    {
      children[column.front()].push_back(static_cast<Index>(k));
    }
  }
  return entries;
}

/// Entries of the factor in the order of rows.
std::int64_t EntriesInOrder(const SparseMatrix& matrix)
{
  std::vector<Index> order(static_cast<std::size_t>(matrix.rows()));
  std::iota(order.begin(), order.end(), 0);
  return FactorEntries(matrix, order);
}

std::int64_t EntriesByAmd(const SparseMatrix& matrix)
{
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> permutation;
  Eigen::AMDOrdering<Index> amd;
  amd(matrix, permutation);
  return FactorEntries(matrix, { permutation.indices().begin(), permutation.indices().end() });
}

using Order = std::function<std::vector<Index>(const SparseMatrix&)>;

/// Checks that an order has every row once, and is the same the second time.
void ExpectOrders(const Order& orderOf, const SparseMatrix& matrix)
{
  const std::vector<Index> order = orderOf(matrix);
  std::vector<Index> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<Index> all(static_cast<std::size_t>(matrix.rows()));
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sorted, all) << matrix.rows();
  EXPECT_EQ(orderOf(matrix), order) << matrix.rows();
}

void ExpectOrdersOfAllKinds(const Order& orderOf)
{
  Edges apart = Grid(60, 60);
  for (const auto& [a, b] : Grid(50, 70))
  {
    apart.emplace_back(3600 + a, 3600 + b);
  }
  for (const SparseMatrix& matrix : { PatternOf(1, {}), PatternOf(5000, {}), PatternOf(5000, Star(4999)),
         PatternOf(4900, Grid(70, 70)), PatternOf(4900, Grid(4900, 1)), PatternOf(7200, apart),
         PatternOf(6000, RandomEdges(6000, 20000)), test::ScreenedCube(14).Matrix })
  {
    ExpectOrders(orderOf, matrix);
  }
}

TEST(NestedDissection, OrdersEveryRowOnceAndAlwaysTheSameWay) { ExpectOrdersOfAllKinds(NestedDissectionOrder); }

std::vector<Index> Windowed(const SparseMatrix& matrix) { return WindowedMinimumDegreeOrder(matrix); }

TEST(WindowedMinimumDegree, OrdersEveryRowOnceAndAlwaysTheSameWay)
{
  ExpectOrdersOfAllKinds(Windowed);
  // Two windows, and so much fill that lists are collected within one.
  ExpectOrders(Windowed, PatternOf(20000, RandomEdges(20000, 50000)));
}

TEST(WindowedMinimumDegree, OrdersRandomGraphsInNarrowWindows)
{
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial)
  {
    const auto size = static_cast<Index>(random() % 200 + 1);
    const auto edges = static_cast<int>(random() % 600); // few: isolated vertices and many components
    const SparseMatrix matrix = PatternOf(size, RandomEdges(size, edges));
    const auto number = [&](unsigned most) { return static_cast<Index>(random() % most); };
    const std::vector<DegreeWindow> windows = { { 1 + number(20), number(6) }, { 1 + number(60), number(12) } };
    ExpectOrders([&](const SparseMatrix& m) { return WindowedMinimumDegreeOrder(m, windows); }, matrix);
    EXPECT_LE(FactorEntries(matrix, WindowedMinimumDegreeOrder(matrix, windows)), EntriesInOrder(matrix)) << trial;
  }
}

TEST(WindowedMinimumDegree, OrdersGraphsWithHubsAndWithoutADiagonal)
{
  Edges hubs = Star(30000);
  for (Index v = 2; v <= 30000; ++v)
  {
    hubs.emplace_back(1, v);
  }
  const std::vector<Index> order = Windowed(PatternOf(30001, hubs));
  EXPECT_THAT(std::vector<Index>(order.end() - 2, order.end()), testing::UnorderedElementsAre(0, 1));
  SparseMatrix cycle(40000, 40000);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index v = 0; v < 40000; ++v)
  {
    entries.emplace_back(v, (v + 1) % 40000, 1.0);
    entries.emplace_back((v + 1) % 40000, v, 1.0);
  }
  cycle.setFromTriplets(entries.begin(), entries.end());
  ExpectOrders(Windowed, cycle);
  EXPECT_EQ(FactorEntries(cycle, Windowed(cycle)), 3 * 40000 - 3);
}

TEST(WindowedMinimumDegree, FactorsOfPathsAndStarsHaveNoMoreEntriesThanTheirMatrices)
{
  const SparseMatrix path = PatternOf(5000, Grid(5000, 1));
  EXPECT_EQ(FactorEntries(path, WindowedMinimumDegreeOrder(path)), 2 * 5000 - 1);
  const SparseMatrix star = PatternOf(5000, Star(4999));
  const std::vector<Index> order = WindowedMinimumDegreeOrder(star);
  EXPECT_EQ(FactorEntries(star, order), 4999 + 5000);
  EXPECT_EQ(order.back(), 0); // more than 10 sqrt(n) neighbors
}

TEST(WindowedMinimumDegree, FactorsAreAsSparseAsThoseOfAmd)
{
  const std::vector<SparseMatrix> matrices = { PatternOf(67600, Grid(260, 260)), // five windows
    test::ScreenedSurface(test::LargeSphere(6)).Matrix, PatternOf(6000, RandomEdges(6000, 20000)) };
  for (const SparseMatrix& matrix : matrices)
  {
    const auto entries = static_cast<double>(FactorEntries(matrix, WindowedMinimumDegreeOrder(matrix)));
    EXPECT_LT(entries, 1.05 * static_cast<double>(EntriesByAmd(matrix))) << matrix.rows();
  }
}

TEST(WindowedMinimumDegree, IsAPostorderOfTheEliminationTreeOfAGrid)
{
  // The descendants of each row are those right before it.
  const SparseMatrix matrix = PatternOf(67600, Grid(260, 260));
  const std::vector<Index> order = WindowedMinimumDegreeOrder(matrix);
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
  {
    place[order[k]] = static_cast<Index>(k);
  }
  std::vector<Index> parent(order.size(), -1);
  std::vector<Index> ancestor(order.size(), -1);
  std::vector<Index> first(order.size());
  std::iota(first.begin(), first.end(), 0);
  for (Index k = 0; k < static_cast<Index>(order.size()); ++k)
  {
    for (SparseMatrix::InnerIterator entry(matrix, order[k]); entry; ++entry)
    {
      for (Index row = place[entry.row()]; row >= 0 && row < k;)
      {
        const Index next = ancestor[row];
        ancestor[row] = k;
        parent[row] = next < 0 ? k : parent[row];
        row = next;
      }
    }
  }
  std::vector<Index> descendants(order.size(), 0);
  Index misplaced = 0;
  for (Index k = 0; k < static_cast<Index>(order.size()); ++k)
  {
    misplaced += k - first[k] != descendants[k];
    if (parent[k] >= 0)
    {
      descendants[parent[k]] += descendants[k] + 1;
      first[parent[k]] = std::min(first[parent[k]], first[k]);
    }
  }
  EXPECT_EQ(misplaced, 0);
}

TEST(WindowedMinimumDegree, OrdersTheFactorsOfLargeSurfaces)
{
  const test::ScreenedMatrix sphere = test::ScreenedSurface(test::LargeSphere(7)); // 163,842 rows
  const CholeskySolver solver(sphere.Matrix);
  EXPECT_EQ(FactorEntries(sphere.Matrix, solver.Order()),
    FactorEntries(sphere.Matrix, WindowedMinimumDegreeOrder(sphere.Matrix)));
  const Eigen::VectorXd side = test::NoiseSides(sphere.Mass, 1).col(0);
  EXPECT_LE(solver.RelativeResidual(solver.Solve(side), side), 1e-12);
}

TEST(NestedDissection, FactorsOfPathsAndStarsHaveHardlyMoreEntriesThanTheirMatrices)
{
  const SparseMatrix path = PatternOf(5000, Grid(5000, 1));
  EXPECT_LE(
    FactorEntries(path, NestedDissectionOrder(path)), 3 * 5000); // 2 where an end is eliminated, 3 in the middle
  const SparseMatrix star = PatternOf(5000, Star(4999));
  EXPECT_EQ(FactorEntries(star, NestedDissectionOrder(star)), 4999 + 5000); // the hub last, or last but one
}

TEST(NestedDissection, FactorsOfVolumesHaveThreeQuartersOfTheEntriesOfAmd)
{
  const SparseMatrix matrix = test::ScreenedCube(26).Matrix;
  const std::int64_t dissected = FactorEntries(matrix, NestedDissectionOrder(matrix));
  const std::int64_t amd = EntriesByAmd(matrix);
  EXPECT_LT(static_cast<double>(dissected), 0.75 * static_cast<double>(amd));
}

TEST(NestedDissection, FactorsOfSurfacesAreAsSparseAsThoseOfAmd)
{
  const SparseMatrix matrix = test::ScreenedSurface(test::LargeSphere(5)).Matrix;
  const std::int64_t dissected = FactorEntries(matrix, NestedDissectionOrder(matrix));
  EXPECT_LT(static_cast<double>(dissected), 1.05 * static_cast<double>(EntriesByAmd(matrix)));
}

TEST(NestedDissection, OrdersTheFactorsOfVolumes)
{
  const test::ScreenedMatrix cube = test::ScreenedCube(22); // 12,167 rows, above the size from which on it is used
  const CholeskySolver solver(cube.Matrix);
  EXPECT_LT(static_cast<double>(solver.FactorEntries()),
    1.45 * static_cast<double>(FactorEntries(cube.Matrix, solver.Order())));
  EXPECT_EQ(FactorEntries(cube.Matrix, solver.Order()), FactorEntries(cube.Matrix, NestedDissectionOrder(cube.Matrix)));
  const Eigen::VectorXd side = test::NoiseSides(cube.Mass, 1).col(0);
  EXPECT_LE(solver.RelativeResidual(solver.Solve(side), side), 1e-12);
}

TEST(GraphPartition, CutsAGridAcrossItsLongSideInTheMiddle)
{
  const WeightedGraph graph = GraphOfPattern(PatternOf(40 * 10, Grid(40, 10)));
  DissectionTree tree;
  std::vector<Index> leaf(400, 0);
  GraphPartition(graph, tree, leaf).SplitLeaves(4, {});
  ASSERT_FALSE(tree.IsLeaf(0));
  const std::uint64_t half = std::uint64_t(1) << 63;
  const auto isSecond = [&](Index v) { return (tree.Path[leaf[v]] & half) != 0; };
  Index cut = 0;
  Index second = 0;
  for (Index v = 0; v < 400; ++v)
  {
    second += isSecond(v);
    for (Index k = graph.Start[v]; k < graph.Start[v + 1]; ++k)
    {
      cut += isSecond(v) && !isSecond(graph.Neighbors[k]);
    }
  }
  EXPECT_EQ(cut, 10);
  EXPECT_THAT(second, testing::AllOf(testing::Ge(140), testing::Le(260))); // 35 % on each side at least
  for (Index node = 0; node < tree.Size(); ++node)
  {
    EXPECT_LE(tree.IsLeaf(node) ? std::count(leaf.begin(), leaf.end(), node) : 0, 160);
  }
}

TEST(GraphPartition, RefinementStraightensARaggedCut)
{
  const Index width = 32;
  const WeightedGraph graph = GraphOfPattern(PatternOf(width * width, Grid(width, width)));
  DissectionTree tree;
  tree.Split(0);
  std::vector<Index> leaf;
  for (Index v = 0; v < width * width; ++v)
  {
    leaf.push_back(v % width + v / width % 3 * 3 < width / 2 + 3 ? 1 : 2); // three lengths of rows in turns
  }
  const auto edgesCut = [&] {
    Index sum = 0;
    for (Index v = 0; v < graph.Size(); ++v)
    {
      for (Index k = graph.Start[v]; k < graph.Start[v + 1]; ++k)
      {
        sum += leaf[v] == 1 && leaf[graph.Neighbors[k]] == 2;
      }
    }
    return sum;
  };
  ASSERT_GT(edgesCut(), 3 * width);
  GraphPartition(graph, tree, leaf).RefineCuts();
  EXPECT_LE(edgesCut(), width + 2);
}

TEST(GraphCoarsening, KeepsWeightsAndEdgesBetweenClusters)
{
  const WeightedGraph graph = GraphOfPattern(PatternOf(600, RandomEdges(600, 2000)));
  const VertexClusters clusters = ClusterVertices(graph, 10);
  const WeightedGraph coarse = CoarsenGraph(graph, clusters);
  ASSERT_EQ(coarse.Size(), clusters.Count);
  EXPECT_LT(coarse.Size(), 400);
  EXPECT_LE(*std::max_element(coarse.Weights.begin(), coarse.Weights.end()), 10);
  EXPECT_EQ(std::accumulate(coarse.Weights.begin(), coarse.Weights.end(), 0), 600);
  Index between = 0;
  for (Index v = 0; v < graph.Size(); ++v)
  {
    for (Index k = graph.Start[v]; k < graph.Start[v + 1]; ++k)
    {
      between += clusters.Of[v] != clusters.Of[graph.Neighbors[k]];
    }
  }
  EXPECT_EQ(std::accumulate(coarse.EdgeWeights.begin(), coarse.EdgeWeights.end(), 0), between);
  for (Index c = 0; c < coarse.Size(); ++c)
  {
    const std::set<Index> others(
      coarse.Neighbors.begin() + coarse.Start[c], coarse.Neighbors.begin() + coarse.Start[c + 1]);
    EXPECT_EQ(static_cast<Index>(others.size()), coarse.Start[c + 1] - coarse.Start[c]);
    EXPECT_EQ(others.count(c), 0U);
  }
}

TEST(VertexCover, IsTheSmallestOneOfRandomGraphs)
{
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial)
  {
    const unsigned left = 1 + random() % 5;
    const unsigned right = 1 + random() % 5;
    std::set<std::pair<Index, Index>> chosen;
    for (unsigned k = random() % 12; k > 0; --k)
    {
      chosen.emplace(static_cast<Index>(random() % left), static_cast<Index>(random() % right));
    }
    unsigned smallest = left + right;
    for (unsigned set = 0; set < 1U << (left + right); ++set)
    {
      const auto isCovered = [&](const auto& edge) {
        return (set >> edge.first & 1) != 0 || (set >> (left + static_cast<unsigned>(edge.second)) & 1) != 0;
      };
      if (std::all_of(chosen.begin(), chosen.end(), isCovered))
      {
        smallest = std::min(smallest, static_cast<unsigned>(__builtin_popcount(set)));
      }
    }
    Edges edges(chosen.begin(), chosen.end());
    const VertexCover cover = MinimumVertexCover(static_cast<Index>(left), static_cast<Index>(right), edges);
    const auto size = std::count(cover.Left.begin(), cover.Left.end(), true) +
      std::count(cover.Right.begin(), cover.Right.end(), true);
    EXPECT_EQ(size, smallest) << trial;
    for (const auto& [a, b] : chosen)
    {
      EXPECT_TRUE(cover.Left[a] || cover.Right[b]) << trial;
    }
  }
}

TEST(VertexCover, IsTheSmallerSideWhereEveryVertexOfItFindsAPartner)
{
  Edges edges; // most of the left side stays without a partner, after searches that all come to the same end
  for (Index a = 0; a < 40000; ++a)
  {
    for (Index k = 0; k < 6; ++k)
    {
      edges.emplace_back(a, (a * 7 + k * k * 613) % 4000);
    }
  }
  const VertexCover cover = MinimumVertexCover(40000, 4000, edges);
  EXPECT_EQ(std::count(cover.Right.begin(), cover.Right.end(), true), 4000);
  EXPECT_EQ(std::count(cover.Left.begin(), cover.Left.end(), true), 0);
}

TEST(GraphPartition, SplitsLeavesThatRefinementLeftLarge)
{
  const WeightedGraph graph = GraphOfPattern(PatternOf(60 * 60, Grid(60, 60)));
  DissectionTree tree;
  std::vector<Index> leaf(3600, 0);
  GraphPartition(graph, tree, leaf).SplitLeaves(1, { 400, 400 });
  std::vector<Index> sizes(static_cast<std::size_t>(tree.Size()), 0);
  for (const Index node : leaf)
  {
    ASSERT_TRUE(tree.IsLeaf(node));
    ++sizes[node];
  }
  EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), 400);
  EXPECT_GT(tree.Size(), 16);
}

TEST(MinimumDegree, EliminatesEndsBeforeTheMiddleAndCountsTheHalo)
{
  MinimumDegree elimination;
  elimination.Begin(4, 3); // the path 2 - 0 - 3 - 1, and 3 has three further neighbors
  const Edges path = { { 2, 0 }, { 0, 3 }, { 3, 1 } };
  for (const auto& [a, b] : path)
  {
    elimination.Connect(a, b);
    elimination.Connect(b, a);
  }
  for (const Index other : { 4, 5, 6 })
  {
    elimination.Connect(3, other);
  }
  // 1 and 2 have one neighbor; without 1, 0 and 2 are still a path to 3, which has four.
  EXPECT_THAT(elimination.Order(), testing::ElementsAre(1, 2, 0, 3));
  elimination.Begin(0, 0);
  EXPECT_TRUE(elimination.Order().empty());
}

TEST(MinimumDegree, ConnectsTheNeighborsOfWhatItEliminates)
{
  MinimumDegree elimination; // a wheel: 0 is the hub of 70 rim vertices, more than a word of bits
  const Index rim = 70;
  elimination.Begin(rim + 1, 0);
  for (Index k = 0; k < rim; ++k)
  {
    for (const Index other : { Index(0), 1 + (k + 1) % rim })
    {
      elimination.Connect(1 + k, other);
      elimination.Connect(other, 1 + k);
    }
  }
  const std::vector<Index>& order = elimination.Order();
  // Rim vertices keep three neighbors until three of them and the hub are left.
  EXPECT_EQ(order.front(), 1);
  EXPECT_GE(std::find(order.begin(), order.end(), 0) - order.begin(), rim - 3);
  EXPECT_EQ(std::set<Index>(order.begin(), order.end()).size(), static_cast<std::size_t>(rim + 1));
}

} // namespace
