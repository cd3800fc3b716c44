// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Properties under their former names, in state files.
#pragma once

namespace surfsynth
{

/// Lets states hand the values of former properties to their successors: to be called once, when the plugin is loaded.
///
/// A property whose name has changed is kept under its former name with the hint <FormerName of="Successor"/>. When a
/// state has been loaded, the value that it gave the former property becomes that of the successor, and the former one
/// is cleared. Without this, the default of the successor would come last and win, or the panel would show it.
void KeepFormerNames();

} // namespace surfsynth
