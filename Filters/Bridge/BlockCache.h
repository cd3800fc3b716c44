// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// What a filter keeps of the blocks of its input from one update to the next.
#pragma once

#include "SurfaceBridge.h"

#include "Core/Mesh/TriangleMesh.h"

#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

namespace surfsynth
{

/// Holds what was prepared for each block of the last update: operators, factors. A block is known by its place (flat
/// index) and its content.
template <typename Prepared>
class BlockCache
{
public:
  /// Called when an update begins, and ...
  void Begin()
  {
    for (auto& entry : this->Entries)
    {
      entry.second.InUse = false;
    }
  }

  /// ... when it has ended: forgets the blocks that are gone, and those that failed.
  void DropUnused()
  {
    for (auto entry = this->Entries.begin(); entry != this->Entries.end();)
    {
      entry = entry->second.InUse ? std::next(entry) : this->Entries.erase(entry);
    }
  }

  /// What is held for this block, or null when there is nothing or the mesh is another one.
  Prepared* Find(const Surface& surface)
  {
    const auto found = this->Entries.find(surface.FlatIndex);
    if (found == this->Entries.end() || found->second.MeshHash != ContentHash(surface.Mesh))
    {
      return nullptr;
    }
    found->second.InUse = true;
    return &found->second.Content;
  }

  /// Forgets what is held for this block: called before its successor is made, so that two are never held.
  void Drop(const Surface& surface) { this->Entries.erase(surface.FlatIndex); }

  Prepared& Insert(const Surface& surface, Prepared content)
  {
    Entry entry{ ContentHash(surface.Mesh), true, std::move(content) };
    return this->Entries.insert_or_assign(surface.FlatIndex, std::move(entry)).first->second.Content;
  }

private:
  struct Entry
  {
    std::uint64_t MeshHash = 0;
    bool InUse = false;
    Prepared Content;
  };
  std::map<unsigned int, Entry> Entries; ///< by flat index
};

} // namespace surfsynth
