# SPDX-License-Identifier: BSD-3-Clause
#
# surfsynth_group_sources(<library>...)
#
# Compiles the sources of each library in groups of twelve: headers cost more than half of the time in which a source is
# compiled. Libraries that group their sources themselves keep to that.
include_guard(GLOBAL)

function (surfsynth_group_sources)
  foreach (library IN LISTS ARGN)
    get_target_property(groups_itself ${library} UNITY_BUILD)
    if (NOT groups_itself)
      set_target_properties(${library} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
      # g++ takes the sources of a group for headers, where types of anonymous namespaces would be mistakes.
      target_compile_options(${library} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    endif ()
  endforeach ()
endfunction ()
