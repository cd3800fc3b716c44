# SPDX-License-Identifier: BSD-3-Clause
#
# Finds CHOLMOD (SuiteSparse) together with the BLAS and LAPACK that it calls.
#
# Defines the imported target
#   SurfaceSynthesis::CHOLMOD    the library cholmod, its include folder, BLAS and LAPACK
# and the variables
#   CHOLMOD_FOUND, CHOLMOD_VERSION, CHOLMOD_INCLUDE_DIR, CHOLMOD_LIBRARY
#
# Hints: CHOLMOD_ROOT or CMAKE_PREFIX_PATH. Use it as
#   list(PREPEND CMAKE_MODULE_PATH <this folder>)
#   find_package(CHOLMOD REQUIRED)
#
# Licences: CHOLMOD is LGPL-2.1+, its supernodal part GPL-2+.

find_path(CHOLMOD_INCLUDE_DIR NAMES cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY NAMES cholmod)
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY)

set(CHOLMOD_VERSION "")
set(_cholmod_header "")
if (CHOLMOD_INCLUDE_DIR)
  # Up to SuiteSparse 5 the version lies in cholmod_core.h, from 6 on in cholmod.h.
  foreach (_cholmod_name IN ITEMS cholmod.h cholmod_core.h)
    if (EXISTS "${CHOLMOD_INCLUDE_DIR}/${_cholmod_name}")
      file(STRINGS "${CHOLMOD_INCLUDE_DIR}/${_cholmod_name}" _cholmod_lines
        REGEX "^#define[ \t]+CHOLMOD_(MAIN|SUB|SUBSUB)_VERSION[ \t]+[0-9]+")
      string(APPEND _cholmod_header "${_cholmod_lines};")
    endif ()
  endforeach ()
  if (_cholmod_header MATCHES "CHOLMOD_MAIN_VERSION[ \t]+([0-9]+)")
    set(CHOLMOD_VERSION "${CMAKE_MATCH_1}")
    foreach (_cholmod_part IN ITEMS SUB SUBSUB)
      if (_cholmod_header MATCHES "CHOLMOD_${_cholmod_part}_VERSION[ \t]+([0-9]+)")
        string(APPEND CHOLMOD_VERSION ".${CMAKE_MATCH_1}")
      endif ()
    endforeach ()
  endif ()
endif ()

find_package(BLAS QUIET)
find_package(LAPACK QUIET)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CHOLMOD
  REQUIRED_VARS CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR BLAS_FOUND LAPACK_FOUND
  VERSION_VAR CHOLMOD_VERSION)

if (CHOLMOD_FOUND AND NOT TARGET SurfaceSynthesis::CHOLMOD)
  add_library(SurfaceSynthesis::CHOLMOD UNKNOWN IMPORTED)
  set_target_properties(SurfaceSynthesis::CHOLMOD PROPERTIES
    IMPORTED_LOCATION "${CHOLMOD_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "LAPACK::LAPACK;BLAS::BLAS")
endif ()
