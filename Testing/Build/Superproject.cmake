# SPDX-License-Identifier: BSD-3-Clause
#
# A superproject that contains this repository as a subfolder, scans it for VTK modules and builds them with its own
# program.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

# A copy, as a superproject would have: its folder may not lie outside. Time stamps are kept, so that what has not
# changed is not compiled again.
file(REMOVE_RECURSE "${WORK_DIR}/Source")
file(COPY "${CMAKE_CURRENT_LIST_DIR}/Superproject/" DESTINATION "${WORK_DIR}/Source")
set(entries "${SOURCE_DIR}/CMakeLists.txt" "${SOURCE_DIR}/vtk.module" "${SOURCE_DIR}/Filters")
if (IS_DIRECTORY "${SOURCE_DIR}/IO")
  list(APPEND entries "${SOURCE_DIR}/IO")
endif ()
file(COPY ${entries} DESTINATION "${WORK_DIR}/Source/SurfaceSynthesis")

# Its programs do little: optimising would take most of the time.
string(TOUPPER "${BUILD_TYPE}" type)
configure_and_build("${WORK_DIR}/Source" "${WORK_DIR}/Build"
  "-DSURFACE_SYNTHESIS_CGAL=OFF" "-DSURFACE_SYNTHESIS_OPENVDB=OFF" "-DSURFACE_SYNTHESIS_LEARNING=OFF"
  "-DSURFACE_SYNTHESIS_TETGEN=${TETGEN}" "-DCMAKE_CXX_FLAGS_${type}=-O0")
run_command("${WORK_DIR}/Build/noise")
if (TETGEN)
  run_command("${WORK_DIR}/Build/tetrahedra")
endif ()
