# SPDX-License-Identifier: BSD-3-Clause
#
# Finds PETSc (BSD-2-Clause) of real numbers with hypre (Apache-2.0 or MIT), together with the MPI that it was built with.
#
# Defines the imported target
#   SurfaceSynthesis::PETSc    the library, its include folder and MPI
# and the variables
#   PETSc_FOUND, PETSc_INCLUDE_DIR, PETSc_LIBRARY
#
# Hints: PETSc_ROOT, PETSC_DIR in the environment, pkg-config. Use it as
#   list(PREPEND CMAKE_MODULE_PATH <this folder>)
#   find_package(PETSc)

find_package(PkgConfig QUIET)
if (PkgConfig_FOUND)
  pkg_check_modules(_petsc QUIET petsc)
endif ()
find_path(PETSc_INCLUDE_DIR NAMES petscksp.h
  HINTS "$ENV{PETSC_DIR}/include" "$ENV{PETSC_DIR}/$ENV{PETSC_ARCH}/include" ${_petsc_INCLUDE_DIRS})
find_library(PETSc_LIBRARY NAMES petsc_real petsc
  HINTS "$ENV{PETSC_DIR}/lib" "$ENV{PETSC_DIR}/$ENV{PETSC_ARCH}/lib" ${_petsc_LIBRARY_DIRS})
mark_as_advanced(PETSc_INCLUDE_DIR PETSc_LIBRARY)
find_package(MPI QUIET COMPONENTS CXX)

set(PETSc_HAS_HYPRE OFF)
if (PETSc_INCLUDE_DIR AND EXISTS "${PETSc_INCLUDE_DIR}/petscconf.h")
  file(STRINGS "${PETSc_INCLUDE_DIR}/petscconf.h" _petsc_hypre REGEX "^#define PETSC_HAVE_HYPRE 1")
  file(STRINGS "${PETSc_INCLUDE_DIR}/petscconf.h" _petsc_other
    REGEX "^#define PETSC_(USE_COMPLEX|USE_64BIT_INDICES|USE_REAL_SINGLE) 1")
  if (_petsc_hypre AND NOT _petsc_other)
    set(PETSc_HAS_HYPRE ON)
  endif ()
endif ()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(PETSc
  REQUIRED_VARS PETSc_LIBRARY PETSc_INCLUDE_DIR PETSc_HAS_HYPRE MPI_CXX_FOUND)

if (PETSc_FOUND AND NOT TARGET SurfaceSynthesis::PETSc)
  add_library(SurfaceSynthesis::PETSc UNKNOWN IMPORTED)
  set_target_properties(SurfaceSynthesis::PETSc PROPERTIES
    IMPORTED_LOCATION "${PETSc_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${PETSc_INCLUDE_DIR}"
    # the C interface only: OpenMPI's headers would bring its own for C++
    INTERFACE_COMPILE_DEFINITIONS "OMPI_SKIP_MPICXX;MPICH_SKIP_MPICXX"
    INTERFACE_LINK_LIBRARIES MPI::MPI_CXX)
endif ()
