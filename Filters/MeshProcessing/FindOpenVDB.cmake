# SPDX-License-Identifier: BSD-3-Clause
#
# Finds OpenVDB (MPL-2.0) together with TBB (Apache-2.0) and Imath's half (BSD-3-Clause), which its headers need.
#
# OpenVDB's own module of this name also asks for Boost, Blosc and ZLIB, which only its library links.
#
# Defines the imported target
#   SurfaceSynthesis::OpenVDB    the library openvdb, its include folder, TBB and Imath
# and the variables
#   OpenVDB_FOUND, OpenVDB_VERSION, OpenVDB_INCLUDE_DIR, OpenVDB_LIBRARY
#
# Hints: OpenVDB_ROOT or CMAKE_PREFIX_PATH. Use it as
#   list(PREPEND CMAKE_MODULE_PATH <this folder>)
#   find_package(OpenVDB 9 REQUIRED)

find_path(OpenVDB_INCLUDE_DIR NAMES openvdb/openvdb.h)
find_library(OpenVDB_LIBRARY NAMES openvdb)
find_path(OpenVDB_TBB_INCLUDE_DIR NAMES tbb/task_arena.h)
find_library(OpenVDB_TBB_LIBRARY NAMES tbb tbb12)
find_path(OpenVDB_IMATH_INCLUDE_DIR NAMES half.h PATH_SUFFIXES Imath)
find_library(OpenVDB_IMATH_LIBRARY NAMES Imath Imath-3_1)
mark_as_advanced(OpenVDB_INCLUDE_DIR OpenVDB_LIBRARY OpenVDB_TBB_INCLUDE_DIR OpenVDB_TBB_LIBRARY
  OpenVDB_IMATH_INCLUDE_DIR OpenVDB_IMATH_LIBRARY)

set(OpenVDB_VERSION "")
set(_openvdb_header "${OpenVDB_INCLUDE_DIR}/openvdb/version.h")
if (OpenVDB_INCLUDE_DIR AND EXISTS "${_openvdb_header}")
  file(STRINGS "${_openvdb_header}" _openvdb_lines
    REGEX "^#define[ \t]+OPENVDB_LIBRARY_(MAJOR|MINOR|PATCH)_VERSION_NUMBER[ \t]+[0-9]+")
  foreach (_openvdb_part IN ITEMS MAJOR MINOR PATCH)
    if ("${_openvdb_lines}" MATCHES "OPENVDB_LIBRARY_${_openvdb_part}_VERSION_NUMBER[ \t]+([0-9]+)")
      string(APPEND OpenVDB_VERSION ".${CMAKE_MATCH_1}")
    endif ()
  endforeach ()
  string(REGEX REPLACE "^\\." "" OpenVDB_VERSION "${OpenVDB_VERSION}")
endif ()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVDB
  REQUIRED_VARS OpenVDB_LIBRARY OpenVDB_INCLUDE_DIR OpenVDB_TBB_LIBRARY OpenVDB_TBB_INCLUDE_DIR
    OpenVDB_IMATH_LIBRARY OpenVDB_IMATH_INCLUDE_DIR
  VERSION_VAR OpenVDB_VERSION)

if (OpenVDB_FOUND AND NOT TARGET SurfaceSynthesis::OpenVDB)
  add_library(SurfaceSynthesis::OpenVDB UNKNOWN IMPORTED)
  set_target_properties(SurfaceSynthesis::OpenVDB PROPERTIES
    IMPORTED_LOCATION "${OpenVDB_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES
      "${OpenVDB_INCLUDE_DIR};${OpenVDB_TBB_INCLUDE_DIR};${OpenVDB_IMATH_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${OpenVDB_TBB_LIBRARY};${OpenVDB_IMATH_LIBRARY}")
endif ()
