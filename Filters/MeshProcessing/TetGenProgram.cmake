# SPDX-License-Identifier: BSD-3-Clause
#
# The program that links TetGen, and nothing else that does. It lies beside the library, which looks for it there:
# in the build tree, in an installed one and among ParaView's plugins.
find_path(TETGEN_INCLUDE_DIR tetgen.h)
find_library(TETGEN_LIBRARY NAMES tet tetgen)
mark_as_advanced(TETGEN_INCLUDE_DIR TETGEN_LIBRARY)
if (NOT TETGEN_INCLUDE_DIR OR NOT TETGEN_LIBRARY)
  message(FATAL_ERROR "TetGen 1.5 (Debian: libtet1.5-dev) was not found. Set TETGEN_INCLUDE_DIR and TETGEN_LIBRARY, or "
    "SURFACE_SYNTHESIS_TETGEN to OFF to build without vtkTetrahedralizeFilter.")
endif ()

add_executable(surfacesynthesis-tetgen Tetrahedra/TetGenProgram.cxx)
target_compile_features(surfacesynthesis-tetgen PRIVATE cxx_std_17)
target_include_directories(surfacesynthesis-tetgen SYSTEM PRIVATE "${TETGEN_INCLUDE_DIR}")
target_include_directories(surfacesynthesis-tetgen PRIVATE "${CMAKE_CURRENT_LIST_DIR}/..")
target_link_libraries(surfacesynthesis-tetgen PRIVATE "${TETGEN_LIBRARY}")
if (COMMAND surfsynth_set_warnings) # absent inside another tree
  surfsynth_set_warnings(surfacesynthesis-tetgen)
endif ()
# It lies beside the library that starts it, wherever both are built, installed or moved to.
include(GNUInstallDirs)
if (CMAKE_LIBRARY_OUTPUT_DIRECTORY)
  set_target_properties(surfacesynthesis-tetgen PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}")
else ()
  set_target_properties(surfacesynthesis-tetgen PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
endif ()
install(TARGETS surfacesynthesis-tetgen
  RUNTIME DESTINATION "${CMAKE_INSTALL_LIBDIR}"
  COMPONENT runtime)
# Whoever builds the library gets a filter that works.
add_dependencies(SurfaceSynthesisMeshProcessing surfacesynthesis-tetgen)
