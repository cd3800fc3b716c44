# SPDX-License-Identifier: BSD-3-Clause
#
# Makes the Debian package of the ParaView plugin as the preset `package-paraview` does, and checks it: dependencies, contents,
# and the plugin in pvbatch, unpacked into a copy of ParaView; the libraries without VTK are those of the build tree.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

set(build "${SOURCE_DIR}/build/plugin-package-test") # two folders below the sources, for ccache
file(REMOVE_RECURSE "${build}/packages")
set(arguments)
foreach (pair IN ITEMS
    "CMAKE_CXX_COMPILER=${COMPILER}" "CMAKE_CXX_FLAGS=${COMPILER_FLAGS}"
    "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" "SURFACE_SYNTHESIS_UNITY=${UNITY}" "SURFACE_SYNTHESIS_WERROR=${WERROR}")
  if (NOT pair MATCHES "=$")
    list(APPEND arguments "-D${pair}")
  endif ()
endforeach ()
run_command("${CMAKE_COMMAND}" -E chdir "${SOURCE_DIR}" "${CMAKE_COMMAND}" --preset package-paraview -B "${build}" ${arguments})
cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
run_command("${CMAKE_COMMAND}" --build "${build}" --parallel ${processors} --target package)

file(GLOB packages "${build}/packages/*.deb")
if (NOT packages MATCHES "^[^;]*/paraview-surfacesynthesis_[0-9.]+-1_[a-z0-9]+\\.deb$")
  message(FATAL_ERROR "One package of the plugin is expected, not '${packages}'")
endif ()
run_command(dpkg-deb -f "${packages}" Depends)
if (NOT OUTPUT MATCHES "libsurfacesynthesis[0-9.]+ \\(= [^)]+\\), paraview \\(>= 5\\.11\\)" OR OUTPUT MATCHES "torch")
  message(FATAL_ERROR "The package depends on ${OUTPUT}")
endif ()

# A copy of ParaView of links, and the package in it.
set(root "${WORK_DIR}/Root")
file(REMOVE_RECURSE "${root}")
file(MAKE_DIRECTORY "${WORK_DIR}")
run_command(cp -al "${PARAVIEW_PREFIX}" "${root}")
file(GLOB_RECURSE before LIST_DIRECTORIES OFF RELATIVE "${root}" "${root}/*")
run_command(dpkg -x "${packages}" "${root}")
file(GLOB_RECURSE added LIST_DIRECTORIES OFF RELATIVE "${root}" "${root}/*")
list(REMOVE_ITEM added ${before})
set(unexpected "${added}")
list(FILTER unexpected EXCLUDE REGEX "/plugins/SurfaceSynthesis/[A-Za-z]+\\.so$|doc/paraview-surfacesynthesis/copyright$")
if (unexpected OR NOT added MATCHES "plugins/SurfaceSynthesis/SurfaceSynthesis\\.so")
  message(FATAL_ERROR "The package has the files ${added}")
endif ()

file(GLOB plugin "${root}/usr/lib/*/paraview-*/plugins/SurfaceSynthesis/SurfaceSynthesis.so")
file(GLOB_RECURSE core "${build}/lib/libSurfaceSynthesisCore.so")
cmake_path(GET core PARENT_PATH libraries)
set(ENV{LD_LIBRARY_PATH} "${libraries}")
set(ENV{SURFACE_SYNTHESIS_PLUGIN} "${plugin}")
unset(ENV{PYTHONPATH})
run_command("${root}/usr/bin/pvbatch" "${SOURCE_DIR}/Testing/ParaView/TestLoad.py")
if (NOT OUTPUT MATCHES "2 of 2 tests passed")
  message(FATAL_ERROR "pvbatch printed ${OUTPUT}")
endif ()
file(REMOVE_RECURSE "${root}")
