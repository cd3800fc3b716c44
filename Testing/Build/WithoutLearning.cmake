# SPDX-License-Identifier: BSD-3-Clause
#
# SURFACE_SYNTHESIS_LEARNING=OFF leaves out Filters/Training alone: all other modules are built, no library needs LibTorch,
# and the Python package applies models.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

set(build "${WORK_DIR}/Source/build/dev")
copy_sources("${WORK_DIR}/Source" CMakeLists.txt Filters IO Wrapping LICENSE)
configure_and_build("${WORK_DIR}/Source" "${build}"
  -DSURFACE_SYNTHESIS_LEARNING=OFF -DSURFACE_SYNTHESIS_CGAL=OFF -DSURFACE_SYNTHESIS_OPENVDB=OFF
  -DSURFACE_SYNTHESIS_TETGEN=OFF -DSURFACE_SYNTHESIS_TESTING=OFF -DSURFACE_SYNTHESIS_BENCHMARKS=OFF
  -DSURFACE_SYNTHESIS_EXAMPLES=OFF -DCMAKE_DISABLE_FIND_PACKAGE_Torch=ON
  "-DSURFACE_SYNTHESIS_WERROR=${WERROR}" "-DPython3_EXECUTABLE=${PYTHON_EXECUTABLE}")
forbid_libraries("${build}/lib" libtorch libc10)

# Every module but Training.
file(GLOB descriptions RELATIVE "${SOURCE_DIR}/Filters" "${SOURCE_DIR}/Filters/*/vtk.module")
foreach (description IN LISTS descriptions)
  cmake_path(GET description PARENT_PATH module)
  file(GLOB library "${build}/lib/libvtkSurfaceSynthesis${module}*.so")
  if (module STREQUAL "Training" AND library)
    message(FATAL_ERROR "${library} was built")
  elseif (NOT module STREQUAL "Training" AND NOT library)
    message(FATAL_ERROR "The module ${module} was not built")
  endif ()
endforeach ()

set(ENV{PYTHONPATH} "${build}/${PYTHON_DESTINATION}")
run_command("${CMAKE_COMMAND}" -E chdir "${WORK_DIR}" "${PYTHON_EXECUTABLE}"
  "${CMAKE_CURRENT_LIST_DIR}/without_learning.py" "${SOURCE_DIR}/Examples/Models")
