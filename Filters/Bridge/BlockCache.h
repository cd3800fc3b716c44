// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Cache of what a filter prepares of the blocks of its input, from one update to the next.
#pragma once

#include "SurfaceBridge.h"

#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

namespace surfsynth
{

/// Holds what was prepared for each block of the last update: operators, factors. A block is known by its place (flat
/// index) and its content (Surface::MeshHash()).
template <typename Prepared>
class BlockCache
{
public:
  /// Marks all blocks as unused: to be called when an update begins.
  void Begin()
  {
    for (auto& entry : this->Entries)
    {
      entry.second.InUse = false;
    }
  }

  /// Forgets the blocks that are gone, and those that failed: to be called when an update has ended.
  void DropUnused()
  {
    for (auto entry = this->Entries.begin(); entry != this->Entries.end();)
    {
      entry = entry->second.InUse ? std::next(entry) : this->Entries.erase(entry);
    }
  }

  /// Returns what is held for this block and marks it as used; null when there is nothing or the mesh is another one.
  Prepared* Find(const Surface& surface)
  {
    return this->Find(surface, [](const Prepared&) { return true; });
  }

  /// The same, and null when @p isCurrent says no to what is held: because options or a model have changed.
  template <typename Predicate>
  Prepared* Find(const Surface& surface, const Predicate& isCurrent)
  {
    const auto found = this->Entries.find(surface.FlatIndex);
    if (found == this->Entries.end() || !isCurrent(std::as_const(found->second.Content)) ||
      found->second.MeshHash != surface.MeshHash())
    {
      return nullptr;
    }
    found->second.InUse = true;
    return &found->second.Content;
  }

  /// Forgets what is held for this block: to be called before its successor is made, so that two are never held.
  void Drop(const Surface& surface) { this->Entries.erase(surface.FlatIndex); }

  /// Holds @p content for this block, marked as used, in place of what was held; the reference is valid until Drop(),
  /// DropUnused() or the next Insert() for the block.
  Prepared& Insert(const Surface& surface, Prepared content)
  {
    Entry entry{ surface.MeshHash(), true, std::move(content) };
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
