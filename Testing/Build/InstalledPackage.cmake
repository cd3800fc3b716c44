# SPDX-License-Identifier: BSD-3-Clause
#
# Installs the build tree into a fresh prefix, moves the prefix, and builds and runs programs against it with
# find_package(SurfaceSynthesis).
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

file(REMOVE_RECURSE "${WORK_DIR}/Installed" "${WORK_DIR}/Prefix")
run_command("${CMAKE_COMMAND}" --install "${TOP_BUILD_DIR}" --prefix "${WORK_DIR}/Installed")
file(RENAME "${WORK_DIR}/Installed" "${WORK_DIR}/Prefix") # an install tree is relocatable
set(prefix "${WORK_DIR}/Prefix")

# No file of the package may point into the source or the build tree.
file(GLOB_RECURSE package_files "${prefix}/*.cmake")
if (NOT package_files)
  message(FATAL_ERROR "No CMake package was installed")
endif ()
foreach (file IN LISTS package_files)
  file(READ "${file}" text)
  foreach (tree IN ITEMS "${SOURCE_DIR}" "${TOP_BUILD_DIR}")
    string(FIND "${text}" "${tree}/" position)
    if (NOT position EQUAL -1)
      message(FATAL_ERROR "${file} names ${tree}")
    endif ()
  endforeach ()
endforeach ()

# The headers of the installed package are used, not those of the source tree.
configure_and_build("${CMAKE_CURRENT_LIST_DIR}/Consumer" "${WORK_DIR}/Build"
  "-DCMAKE_PREFIX_PATH=${prefix}" "-DEXPECTED_PREFIX=${prefix}" "-DNOISE_SOURCE_DIR=${CMAKE_CURRENT_LIST_DIR}/Superproject"
  "-DLEARNING=${LEARNING}" "-DWITH_TETGEN=${TETGEN}")
run_command("${WORK_DIR}/Build/noise")
if (TETGEN)
  # The program that runs TetGen is found in the moved prefix, and the AGPL stays in it.
  run_command("${WORK_DIR}/Build/tetrahedra")
  forbid_libraries("${prefix}" "libtet[.0-9]")
endif ()
run_command("${WORK_DIR}/Build/core")
run_command("${CMAKE_COMMAND}" -E chdir "${WORK_DIR}" "${WORK_DIR}/Build/inference")
if (LEARNING)
  run_command("${prefix}/bin/surfacesynthesis-train" --help) # finds its libraries in the moved prefix
endif ()

# The program of README.md, from an empty folder: by the installed package, and by the build folder.
file(READ "${SOURCE_DIR}/README.md" readme)
if (NOT readme MATCHES "```cpp\n((#include [^\n]*\n)+)\n([^`]*)```")
  message(FATAL_ERROR "README.md has no C++ program that begins with #include")
endif ()
set(readme_folder "${WORK_DIR}/Readme")
file(REMOVE_RECURSE "${readme_folder}")
file(WRITE "${readme_folder}/main.cxx" "${CMAKE_MATCH_1}\nint main()\n{\n${CMAKE_MATCH_3}}\n")
if (NOT readme MATCHES "`(target_link_libraries\\([^`]*\\))`")
  message(FATAL_ERROR "README.md does not tell what the program links")
endif ()
file(WRITE "${readme_folder}/CMakeLists.txt" "cmake_minimum_required(VERSION 3.24)
project(Readme CXX)
find_package(SurfaceSynthesis REQUIRED)
add_executable(app main.cxx)
${CMAKE_MATCH_1}
")
set(stl "solid tetrahedron\n")
foreach (triangle IN ITEMS "0 0 0|0 9 0|9 0 0" "0 0 0|9 0 0|0 0 9" "9 0 0|0 9 0|0 0 9" "0 9 0|0 0 0|0 0 9")
  string(REPLACE "|" "\nvertex " vertices "${triangle}")
  string(APPEND stl "facet normal 0 0 1\nouter loop\nvertex ${vertices}\nendloop\nendfacet\n")
endforeach ()
file(WRITE "${readme_folder}/surface.stl" "${stl}endsolid tetrahedron\n")
configure_and_build("${readme_folder}" "${readme_folder}/Installed" "-DCMAKE_PREFIX_PATH=${prefix}")
configure_and_build("${readme_folder}" "${readme_folder}/BuildFolder" "-DSurfaceSynthesis_DIR=${TOP_BUILD_DIR}")
foreach (folder IN ITEMS Installed BuildFolder)
  run_command("${CMAKE_COMMAND}" -E chdir "${readme_folder}" "${readme_folder}/${folder}/app")
  if (OUTPUT MATCHES "ERR")
    message(FATAL_ERROR "The program of README.md printed\n${OUTPUT}")
  endif ()
endforeach ()

# The same program finds Core alone, and does not look for VTK.
configure_and_build("${CMAKE_CURRENT_LIST_DIR}/Consumer" "${WORK_DIR}/BuildCore"
  "-DCMAKE_PREFIX_PATH=${prefix}" "-DEXPECTED_PREFIX=${prefix}" -DCORE_ONLY=ON)
run_command("${WORK_DIR}/BuildCore/core")

if (PYTHON)
  set(ENV{PYTHONPATH} "${prefix}/${PYTHON_DESTINATION}")
  run_command("${CMAKE_COMMAND}" -E chdir "${WORK_DIR}" "${PYTHON_EXECUTABLE}" -c
    "import surfacesynthesis as s\nassert s.__file__.startswith('${prefix}/'), s.__file__\ns.vtkMaternNoiseFilter().Update")
endif ()
