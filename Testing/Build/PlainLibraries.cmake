# SPDX-License-Identifier: BSD-3-Clause
#
# The plain libraries without VTK, CHOLMOD, PETSc and LibTorch, and tests of what CHOLMOD would do. The others run the same
# objects as in the outer build.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

set(build "${WORK_DIR}/Source/build/dev")
copy_sources("${WORK_DIR}/Source" CMakeLists.txt Filters IO Wrapping Testing Examples LICENSE)
set(tests TestEigenpairs TestFieldConditioning TestHeatGeodesics TestMaternField TestPoissonOperators TestSolvers)
configure_and_build("${WORK_DIR}/Source" "${build}"
  -DSURFACE_SYNTHESIS_VTK=OFF -DSURFACE_SYNTHESIS_CHOLMOD=OFF -DSURFACE_SYNTHESIS_PETSC=OFF -DSURFACE_SYNTHESIS_LEARNING=OFF
  -DSURFACE_SYNTHESIS_CGAL=OFF -DSURFACE_SYNTHESIS_OPENVDB=OFF -DSURFACE_SYNTHESIS_TETGEN=OFF
  -DSURFACE_SYNTHESIS_BENCHMARKS=OFF "-DSURFACE_SYNTHESIS_WERROR=${WERROR}"
  TARGETS surfsynth_libraries ${tests})
forbid_libraries("${build}/lib" libvtk libcholmod libtorch libpetsc libmpi)

cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
# Statistics are tested once, in the outer build.
set(ENV{GTEST_FILTER} "-*MaternOnSphere*:*DeviationAskedFor*:*CorrelationAtTheRange*")
list(JOIN tests "|" tests)
run_command("${CMAKE_CTEST_COMMAND}" --test-dir "${build}" --output-on-failure --no-tests=error
  --tests-regex "^(${tests})$" --parallel ${processors})
string(REGEX MATCH "[0-9]+% tests passed[^\n]*" summary "${OUTPUT}")
message(STATUS "${summary}")
