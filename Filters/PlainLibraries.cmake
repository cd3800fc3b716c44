# SPDX-License-Identifier: BSD-3-Clause
#
# The plain libraries: CMake libraries without VTK that the VTK modules link.
#
# The root CMakeLists.txt includes this file in a standalone build. In a tree that scans this repository for VTK modules
# that file is read last or never, so each module that links a plain library begins with
#
#   include("${CMAKE_CURRENT_SOURCE_DIR}/../PlainLibraries.cmake")
#
# and the first one to do so adds the libraries.
#
# Defines the targets SurfaceSynthesis::<name> for each name in SURFACE_SYNTHESIS_PLAIN_LIBRARIES.
include_guard(GLOBAL)

# The targets of what the plain libraries link must be known wherever a plain library is linked.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)

set(SURFACE_SYNTHESIS_PLAIN_LIBRARIES
  SurfaceSynthesisCore SurfaceSynthesisWeights SurfaceSynthesisDatasets SurfaceSynthesisInference)
add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/Core" "${CMAKE_BINARY_DIR}/Filters/Core")
add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/../IO/Weights" "${CMAKE_BINARY_DIR}/IO/Weights")
add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/../IO/Datasets" "${CMAKE_BINARY_DIR}/IO/Datasets")
add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/Inference" "${CMAKE_BINARY_DIR}/Filters/Inference")
add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/MeshProcessing" "${CMAKE_BINARY_DIR}/Filters/MeshProcessing")
if (TARGET SurfaceSynthesisMeshProcessing)
  list(APPEND SURFACE_SYNTHESIS_PLAIN_LIBRARIES SurfaceSynthesisMeshProcessing)
endif ()
add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/Distributed" "${CMAKE_BINARY_DIR}/Filters/Distributed")
if (TARGET SurfaceSynthesisDistributed)
  list(APPEND SURFACE_SYNTHESIS_PLAIN_LIBRARIES SurfaceSynthesisDistributed)
endif ()
option(SURFACE_SYNTHESIS_LEARNING "Build the training of models (LibTorch: BSD-3-Clause)" ON)
if (SURFACE_SYNTHESIS_LEARNING)
  list(APPEND SURFACE_SYNTHESIS_PLAIN_LIBRARIES SurfaceSynthesisLearning)
  add_subdirectory("${CMAKE_CURRENT_LIST_DIR}/Learning" "${CMAKE_BINARY_DIR}/Filters/Learning")
endif ()

unset(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL)

include(GNUInstallDirs)
foreach (library IN LISTS SURFACE_SYNTHESIS_PLAIN_LIBRARIES)
  set(component runtime)
  if (library STREQUAL "SurfaceSynthesisLearning")
    set(component training) # a package of its own: LibTorch is ten times as large as all the rest
  endif ()
  install(TARGETS ${library}
    EXPORT SurfaceSynthesisPlainLibraries
    RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT ${component}
    LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${component} NAMELINK_COMPONENT development
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)
endforeach ()
# The public headers are those that a library lists among its sources. They are included by their path below Filters, or
# for what lies beside it (IO) below the root.
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH root)
foreach (library IN LISTS SURFACE_SYNTHESIS_PLAIN_LIBRARIES)
  get_target_property(folder ${library} SOURCE_DIR)
  get_target_property(headers ${library} SOURCES)
  list(FILTER headers INCLUDE REGEX "\\.h$")
  foreach (header IN LISTS headers)
    cmake_path(ABSOLUTE_PATH header BASE_DIRECTORY "${folder}" NORMALIZE)
    cmake_path(IS_PREFIX CMAKE_CURRENT_LIST_DIR "${header}" in_filters)
    if (in_filters)
      file(RELATIVE_PATH subfolder "${CMAKE_CURRENT_LIST_DIR}" "${header}")
    else ()
      file(RELATIVE_PATH subfolder "${root}" "${header}")
    endif ()
    cmake_path(GET subfolder PARENT_PATH subfolder)
    install(FILES "${header}"
      DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/SurfaceSynthesis/${subfolder}"
      COMPONENT development)
  endforeach ()
endforeach ()
install(EXPORT SurfaceSynthesisPlainLibraries
  NAMESPACE SurfaceSynthesis::
  FILE SurfaceSynthesisPlainLibraries.cmake
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/SurfaceSynthesis"
  COMPONENT development)
export(EXPORT SurfaceSynthesisPlainLibraries
  NAMESPACE SurfaceSynthesis::
  FILE "${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}/cmake/SurfaceSynthesis/SurfaceSynthesisPlainLibraries.cmake")

include("${CMAKE_CURRENT_LIST_DIR}/CheckBLAS.cmake")
if (SURFACE_SYNTHESIS_CHOLMOD)
  surfsynth_check_blas(SurfaceSynthesis::CHOLMOD)
endif ()
if (SURFACE_SYNTHESIS_LEARNING)
  surfsynth_check_torch_blas("${TORCH_LIBRARY}")
endif ()
