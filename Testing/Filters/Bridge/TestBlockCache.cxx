// SPDX-License-Identifier: BSD-3-Clause
//
// The cache of what filters prepare of the blocks of their input, and the hash by which it knows a mesh.
#include "FilterChecks.h"
#include "VtkSurfaces.h"

#include "BlockCache.h"

#include "Core/Mesh/TriangleMesh.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

using namespace surfsynthtest;
using surfsynth::BlockCache;
using surfsynth::Surface;

namespace
{
Surface SurfaceAt(unsigned int flatIndex, int level = 1)
{
  Surface surface = surfsynth::ConvertSurface(Icosphere(level).ToPolyData());
  surface.FlatIndex = flatIndex;
  return surface;
}
} // namespace

TEST(MeshHash, IsThatOfTheMesh)
{
  const Surface surface = SurfaceAt(0);
  EXPECT_EQ(surface.MeshHash(), surfsynth::ContentHash(surface.Mesh));
  EXPECT_NE(surface.MeshHash(), SurfaceAt(0, 2).MeshHash());
  EXPECT_EQ(surface.MeshHash(), SurfaceAt(3).MeshHash()) << "the place is no part of the mesh";
}

TEST(MeshHash, IsComputedOnceForEachSurface)
{
  Surface surface = SurfaceAt(0);
  const auto hash = surface.MeshHash();
  surface.Mesh.Points(0, 0) += 1.0; // not allowed: it shows that the mesh is not looked at again
  EXPECT_EQ(surface.MeshHash(), hash);
  const Surface copy = surface;
  EXPECT_EQ(copy.MeshHash(), hash) << "a copy carries the hash";
  Surface fresh;
  fresh.Mesh = surface.Mesh;
  EXPECT_NE(fresh.MeshHash(), hash);
}

TEST(BlockCache, FindAndInsertHashAMeshOnce)
{
  BlockCache<int> first;
  BlockCache<int> second;
  Surface surface = SurfaceAt(2);
  EXPECT_EQ(first.Find(surface), nullptr);
  first.Insert(surface, 5);
  surface.Mesh.Points(0, 0) += 1.0; // not allowed: a cache that hashed again would take it for another mesh
  second.Insert(surface, 6);
  ASSERT_TRUE(first.Find(surface));
  ASSERT_TRUE(first.Find(SurfaceAt(2)));
  ASSERT_TRUE(second.Find(SurfaceAt(2))) << "all caches know the mesh by one hash";
  EXPECT_EQ(*second.Find(SurfaceAt(2)), 6);
}

TEST(BlockCache, ABlockIsKnownByPlaceAndMesh)
{
  BlockCache<std::string> cache;
  cache.Insert(SurfaceAt(1), "one");
  cache.Insert(SurfaceAt(2), "two");
  ASSERT_TRUE(cache.Find(SurfaceAt(1)));
  EXPECT_EQ(*cache.Find(SurfaceAt(1)), "one");
  EXPECT_EQ(*cache.Find(SurfaceAt(2)), "two");
  EXPECT_EQ(cache.Find(SurfaceAt(3)), nullptr) << "another place";
  EXPECT_EQ(cache.Find(SurfaceAt(1, 2)), nullptr) << "another mesh";
}

TEST(BlockCache, WhatIsNotCurrentIsNotFound)
{
  BlockCache<int> cache;
  cache.Insert(SurfaceAt(1), 7);
  EXPECT_EQ(cache.Find(SurfaceAt(1), [](int held) { return held == 8; }), nullptr);
  ASSERT_TRUE(cache.Find(SurfaceAt(1), [](int held) { return held == 7; }));
  cache.Begin();
  cache.Find(SurfaceAt(1), [](int) { return false; });
  cache.DropUnused();
  EXPECT_EQ(cache.Find(SurfaceAt(1)), nullptr) << "and is not marked as used";
}

TEST(BlockCache, BlocksThatAnUpdateDidNotUseAreDropped)
{
  BlockCache<int> cache;
  cache.Begin();
  cache.Insert(SurfaceAt(1), 1);
  cache.Insert(SurfaceAt(2), 2);
  cache.DropUnused();
  cache.Begin();
  ASSERT_TRUE(cache.Find(SurfaceAt(1)));
  cache.Find(SurfaceAt(2, 2)); // another mesh: not used
  cache.DropUnused();
  EXPECT_TRUE(cache.Find(SurfaceAt(1)));
  EXPECT_EQ(cache.Find(SurfaceAt(2)), nullptr);
}

TEST(BlockCache, TwoAreNeverHeldForOneBlock)
{
  BlockCache<std::shared_ptr<int>> cache;
  const auto first = std::make_shared<int>(1);
  cache.Insert(SurfaceAt(1), first);
  EXPECT_EQ(first.use_count(), 2);
  cache.Drop(SurfaceAt(1, 2)); // its successor is for another mesh
  EXPECT_EQ(first.use_count(), 1);
  EXPECT_EQ(cache.Find(SurfaceAt(1)), nullptr);
  EXPECT_EQ(*cache.Insert(SurfaceAt(1), std::make_shared<int>(2)), 2);
  cache.Insert(SurfaceAt(1, 2), std::make_shared<int>(3));
  EXPECT_EQ(cache.Find(SurfaceAt(1)), nullptr) << "replaced";
}
