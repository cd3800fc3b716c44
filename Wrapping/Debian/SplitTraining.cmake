# SPDX-License-Identifier: BSD-3-Clause
#
# Run by CPack before it packs: what links LibTorch moves from the packages of the libraries and of Python to that of
# training. vtk_module_build() and vtk_module_wrap_python() install all modules as one component.
set(staging "${CPACK_TEMPORARY_DIRECTORY}")
if (IS_DIRECTORY "${staging}/training")
  foreach (component IN ITEMS runtime python)
    file(GLOB_RECURSE files LIST_DIRECTORIES OFF RELATIVE "${staging}/${component}"
      "${staging}/${component}/*vtkSurfaceSynthesisTraining*.so*")
    foreach (file IN LISTS files)
      cmake_path(GET file PARENT_PATH folder)
      file(MAKE_DIRECTORY "${staging}/training/${folder}")
      file(RENAME "${staging}/${component}/${file}" "${staging}/training/${file}")
    endforeach ()
  endforeach ()
endif ()
