# SPDX-License-Identifier: BSD-3-Clause
#
# Checks by reading that includes point down the layers, never up, and that the tree has the layout it should:
#
#   Wrapping, Examples, Testing          use everything below
#     Filters/<Module>                   VTK modules
#       Filters/Bridge                   no torch
#       Filters/Learning                 no VTK
#         IO/Weights, IO/Mesh            no VTK, no torch
#           Filters/Core                 no VTK, no torch
#
# -DSOURCE_DIR=<root of the repository>. Prints every violation and fails when there is one, or when there is nothing to
# check.
cmake_minimum_required(VERSION 3.24)

set(violations "")
set(number_of_files 0)
set(number_of_includes 0)

# forbid(<what> <regex of an include> <reason> <glob relative to the root>...)
function (forbid what pattern reason)
  set(globs ${ARGN})
  list(TRANSFORM globs PREPEND "${SOURCE_DIR}/")
  file(GLOB_RECURSE files ${globs})
  foreach (file IN LISTS files)
    math(EXPR number_of_files "${number_of_files} + 1")
    file(STRINGS "${file}" lines REGEX "^[ \t]*#[ \t]*include[ \t]*[<\"]")
    foreach (line IN LISTS lines)
      math(EXPR number_of_includes "${number_of_includes} + 1")
      if (line MATCHES "[<\"](${pattern})")
        file(RELATIVE_PATH name "${SOURCE_DIR}" "${file}")
        string(APPEND violations "  ${name}: ${line}\n    ${what}: ${reason}\n")
      endif ()
    endforeach ()
  endforeach ()
  set(violations "${violations}" PARENT_SCOPE)
  set(number_of_files "${number_of_files}" PARENT_SCOPE)
  set(number_of_includes "${number_of_includes}" PARENT_SCOPE)
endfunction ()

set(vtk "vtk[A-Z]")
set(torch "torch/|ATen/|c10/")
# A VTK class that the wrapper reads: headers named vtk*.h.
set(heavy "${torch}|Eigen/|unsupported/Eigen|CGAL/|openvdb/|tetgen|cholmod|Spectra/|Core/|Learning/|IO/Weights/|IO/Mesh/|Weights/")

forbid("VTK in a plain library" "${vtk}" "it must build without VTK"
  "Filters/Core/*.h" "Filters/Core/*.cxx" "Filters/Learning/*.h" "Filters/Learning/*.cxx"
  "IO/Weights/*.h" "IO/Weights/*.cxx" "IO/Mesh/*.h" "IO/Mesh/*.cxx")
forbid("torch below Learning" "${torch}" "only Learning and the filters above it use LibTorch"
  "Filters/Core/*.h" "Filters/Core/*.cxx" "Filters/Bridge/*.h" "Filters/Bridge/*.cxx"
  "Filters/Noise/*.h" "Filters/Noise/*.cxx" "Filters/Meshing/*.h" "Filters/Meshing/*.cxx"
  "IO/Weights/*.h" "IO/Weights/*.cxx" "IO/Mesh/*.h" "IO/Mesh/*.cxx")
forbid("algorithm in the header of a VTK class" "${heavy}" "it belongs behind std::unique_ptr<Internals>"
  "Filters/vtk*.h" "IO/vtk*.h")
forbid("include up the layers" "(\\.\\./)*(Noise/vtk|(Bridge|Learning|Prediction|Deformation|Texture|Geometry|Meshing|IO|Weights)/)|SurfaceBridge\\.h"
  "Core is the lowest layer" "Filters/Core/*.h" "Filters/Core/*.cxx")
forbid("include up the layers" "(\\.\\./)*(Noise/vtk|(Bridge|Learning|Prediction|Deformation|Texture|Geometry|Meshing)/)|SurfaceBridge\\.h"
  "IO/Weights and IO/Mesh lie below"
  "IO/Weights/*.h" "IO/Weights/*.cxx" "IO/Mesh/*.h" "IO/Mesh/*.cxx")
forbid("include up the layers" "(\\.\\./)*Bridge/|SurfaceBridge\\.h" "Learning lies below"
  "Filters/Learning/*.h" "Filters/Learning/*.cxx")
forbid("a sibling module in Bridge" "(\\.\\./)*(Noise/vtk|(Learning|Prediction|Deformation|Texture|Geometry|Meshing)/)"
  "Bridge lies below the filters" "Filters/Bridge/*.h" "Filters/Bridge/*.cxx")
forbid("tests in the library" "gtest/|gmock/|benchmark/|Testing/" "the library does not know its tests"
  "Filters/*.h" "Filters/*.cxx" "IO/*.h" "IO/*.cxx")

# Random numbers come from explicit seeds and are the same on every platform.
file(GLOB_RECURSE sources "${SOURCE_DIR}/Filters/*.h" "${SOURCE_DIR}/Filters/*.cxx"
  "${SOURCE_DIR}/IO/*.h" "${SOURCE_DIR}/IO/*.cxx")
foreach (file IN LISTS sources)
  file(STRINGS "${file}" lines REGEX "std::(random_device|[a-z_]+_distribution)|[^a-zA-Z_:]s?rand\\(")
  foreach (line IN LISTS lines)
    if (NOT line MATCHES "^[ \t]*//")
      file(RELATIVE_PATH name "${SOURCE_DIR}" "${file}")
      string(APPEND violations "  ${name}: ${line}\n    randomness must come from an explicit seed\n")
    endif ()
  endforeach ()
endforeach ()

# Every source names its licence in its first two lines.
set(globs)
foreach (folder IN ITEMS Filters IO Wrapping Testing Examples)
  foreach (extension IN ITEMS h cxx py cmake sh module in)
    list(APPEND globs "${SOURCE_DIR}/${folder}/*.${extension}")
  endforeach ()
  list(APPEND globs "${SOURCE_DIR}/${folder}/CMakeLists.txt")
endforeach ()
file(GLOB_RECURSE sources ${globs})
foreach (file IN LISTS sources)
  file(STRINGS "${file}" lines LIMIT_COUNT 2)
  if (NOT lines MATCHES "SPDX-License-Identifier: BSD-3-Clause")
    file(RELATIVE_PATH name "${SOURCE_DIR}" "${file}")
    string(APPEND violations "  ${name}: does not begin with the SPDX line\n")
  endif ()
endforeach ()

# The top level is fixed. In a clone only what git tracks counts.
set(top_level CMakeLists.txt Filters IO Wrapping Testing Examples vtk.module README.md LICENSE CMakePresets.json)
set(entries "")
find_program(GIT_PROGRAM git)
if (EXISTS "${SOURCE_DIR}/.git" AND GIT_PROGRAM)
  execute_process(COMMAND "${GIT_PROGRAM}" -c safe.directory=* -C "${SOURCE_DIR}" ls-tree --name-only HEAD
    OUTPUT_VARIABLE entries RESULT_VARIABLE result OUTPUT_STRIP_TRAILING_WHITESPACE)
  if (NOT result STREQUAL "0")
    message(FATAL_ERROR "git ls-tree failed in ${SOURCE_DIR}")
  endif ()
  string(REPLACE "\n" ";" entries "${entries}")
endif ()
foreach (entry IN LISTS entries)
  if (NOT entry IN_LIST top_level AND NOT entry MATCHES "^\\.")
    string(APPEND violations "  ${entry}: does not belong in the top-level folder\n")
  endif ()
endforeach ()

if (number_of_files LESS 20 OR number_of_includes LESS 50)
  message(FATAL_ERROR "Only ${number_of_files} files with ${number_of_includes} includes in ${SOURCE_DIR}")
endif ()
if (violations)
  message(FATAL_ERROR "Violations of the layering:\n${violations}")
endif ()
message(STATUS "${number_of_includes} includes in ${number_of_files} readings of files keep to the layers")
