# SPDX-License-Identifier: BSD-3-Clause
#
# pip install . into a virtual environment, without a package index, and a run of the installed package there.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

# scikit-build compiles three folders below the sources; the link makes them two, as in the other trees, for ccache.
run_command("${PYTHON_EXECUTABLE}" -c
  "import skbuild.constants as c, os\nprint(os.path.dirname(c.CMAKE_BUILD_DIR()), os.path.basename(c.CMAKE_BUILD_DIR()))")
string(STRIP "${OUTPUT}" OUTPUT)
string(REPLACE " " ";" OUTPUT "${OUTPUT}")
list(POP_FRONT OUTPUT folder name)
file(REMOVE_RECURSE "${SOURCE_DIR}/_skbuild")
file(MAKE_DIRECTORY "${SOURCE_DIR}/${folder}" "${SOURCE_DIR}/build/wheel-test")
file(CREATE_LINK "${SOURCE_DIR}/build/wheel-test" "${SOURCE_DIR}/${folder}/${name}" SYMBOLIC)

set(options)
foreach (pair IN ITEMS
    "CMAKE_CXX_COMPILER=${COMPILER}" "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" "SURFACE_SYNTHESIS_UNITY=${UNITY}"
    "SURFACE_SYNTHESIS_WERROR=${WERROR}" "SURFACE_SYNTHESIS_CHOLMOD=${CHOLMOD}" "SURFACE_SYNTHESIS_TETGEN=${TETGEN}"
    "SURFACE_SYNTHESIS_LEARNING=${LEARNING}")
  if (NOT pair MATCHES "=$")
    string(APPEND options " -D${pair}")
  endif ()
endforeach ()
set(ENV{SKBUILD_CONFIGURE_OPTIONS} "${options}")
unset(ENV{PYTHONPATH})
set(environment "${WORK_DIR}/Environment")
file(REMOVE_RECURSE "${environment}")
run_command("${PYTHON_EXECUTABLE}" -m venv --system-site-packages "${environment}")
run_command("${environment}/bin/python3" -m pip install --no-index --no-deps --no-build-isolation "${SOURCE_DIR}")
file(REMOVE_RECURSE "${SOURCE_DIR}/_skbuild")
file(GLOB left "${SOURCE_DIR}/*.egg-info" "${SOURCE_DIR}/Wrapping/Python/*.egg-info")
foreach (folder IN LISTS left)
  file(REMOVE_RECURSE "${folder}")
endforeach ()

# Each library once; nothing of development, no path of the sources or the build.
file(GLOB_RECURSE files RELATIVE "${environment}" "${environment}/lib/*/site-packages/surfacesynthesis/*")
list(FILTER files INCLUDE REGEX "lib/libSurfaceSynthesisCore|\\.h$|\\.cmake$|safetensors$|libvtkSurfaceSynthesisNoise")
set(development ${files})
list(FILTER development INCLUDE REGEX "\\.(h|cmake)$")
set(libraries ${files})
list(FILTER libraries INCLUDE REGEX "libSurfaceSynthesisCore")
list(LENGTH libraries count)
if (development OR NOT count EQUAL 1)
  message(FATAL_ERROR "The environment holds ${files}")
endif ()
set(ENV{PYTHONDONTWRITEBYTECODE} 1)
run_command("${CMAKE_COMMAND}" -E chdir "${WORK_DIR}" "${environment}/bin/python3" -c
  "import surfacesynthesis as s, sys\nassert s.__file__.startswith(sys.prefix), s.__file__\nprint(s.__version__)")
file(WRITE "${WORK_DIR}/tetrahedron.off"
  "OFF\n4 4 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
set(run "${CMAKE_COMMAND}" -E chdir "${WORK_DIR}" "${environment}/bin/surfacesynthesis")
run_command(${run} remesh tetrahedron.off even.vtp --points 300)
run_command(${run} noise even.vtp noise.vtp --range 3)
run_command(${run} sample-texture even.vtp coat.obj --model coat --points 300 --steps 2 --resolution 64)
if (TETGEN)
  run_command(${run} tetrahedralize noise.vtp volume.vtu)
endif ()
if (LEARNING)
  run_command("${CMAKE_COMMAND}" -E chdir "${WORK_DIR}" "${environment}/bin/python3" -c
    "import surfacesynthesis as s\ns.vtkFlowMatchingTrainer()")
endif ()
