# SPDX-License-Identifier: BSD-3-Clause
#
# Makes the Debian packages as the preset `package` does, and checks them: names, dependencies and contents; programs, Python
# and find_package(SurfaceSynthesis) in the unpacked files; installation and first picture in a minimal Debian
# (debian_packages.py).
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

set(build "${SOURCE_DIR}/build/package-test") # two folders below the sources, for ccache
file(REMOVE_RECURSE "${build}/packages")
set(arguments)
foreach (pair IN ITEMS
    "CMAKE_CXX_COMPILER=${COMPILER}" "CMAKE_CXX_FLAGS=${COMPILER_FLAGS}"
    "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" "SURFACE_SYNTHESIS_UNITY=${UNITY}"
    "SURFACE_SYNTHESIS_WERROR=${WERROR}" "SURFACE_SYNTHESIS_CHOLMOD=${CHOLMOD}"
    "SURFACE_SYNTHESIS_TETGEN=${TETGEN}" "SURFACE_SYNTHESIS_LEARNING=${LEARNING}")
  if (NOT pair MATCHES "=$")
    list(APPEND arguments "-D${pair}")
  endif ()
endforeach ()
run_command("${CMAKE_COMMAND}" -E chdir "${SOURCE_DIR}" "${CMAKE_COMMAND}" --preset package -B "${build}" ${arguments})
cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
run_command("${CMAKE_COMMAND}" --build "${build}" --parallel ${processors} --target package)

set(root "${WORK_DIR}/Root")
file(REMOVE_RECURSE "${root}")
run_command("${PYTHON_EXECUTABLE}" -B "${CMAKE_CURRENT_LIST_DIR}/debian_packages.py"
  "${build}/packages" "${root}" "${SOURCE_DIR}" "${WORK_DIR}")
message(STATUS "${OUTPUT}")

# Programs find the packages' headers, libraries and CMake files.
file(GLOB libraries "${root}/usr/lib/*/libSurfaceSynthesisCore.so.*.*.*")
cmake_path(GET libraries PARENT_PATH libraries)
set(ENV{LD_LIBRARY_PATH} "${libraries}")
configure_and_build("${CMAKE_CURRENT_LIST_DIR}/Consumer" "${WORK_DIR}/Consumer"
  "-DCMAKE_PREFIX_PATH=${root}/usr" "-DEXPECTED_PREFIX=${root}/usr"
  "-DNOISE_SOURCE_DIR=${CMAKE_CURRENT_LIST_DIR}/Superproject" "-DLEARNING=${LEARNING}" "-DWITH_TETGEN=${TETGEN}")
run_command("${WORK_DIR}/Consumer/noise")
run_command("${WORK_DIR}/Consumer/core")
