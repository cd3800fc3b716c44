# SPDX-License-Identifier: BSD-3-Clause
#
# A superproject that contains this repository as a subfolder, scans it for VTK modules, configures them all, and builds two
# programs with the modules that they link.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

set(source "${WORK_DIR}/Source")
file(REMOVE_RECURSE "${source}")
file(COPY "${CMAKE_CURRENT_LIST_DIR}/Superproject/" DESTINATION "${source}")
copy_sources("${source}/SurfaceSynthesis" CMakeLists.txt vtk.module Filters IO)

set(programs noise)
if (TETGEN)
  list(APPEND programs tetrahedra)
endif ()
set(build "${source}/SurfaceSynthesis/build/dev")
configure_and_build("${source}" "${build}"
  "-DSURFACE_SYNTHESIS_CGAL=OFF" "-DSURFACE_SYNTHESIS_OPENVDB=OFF" "-DSURFACE_SYNTHESIS_LEARNING=OFF"
  "-DSURFACE_SYNTHESIS_TETGEN=${TETGEN}" "-DWERROR=${WERROR}"
  TARGETS ${programs})
foreach (program IN LISTS programs)
  run_command("${build}/${program}")
endforeach ()
