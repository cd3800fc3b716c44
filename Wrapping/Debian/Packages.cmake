# SPDX-License-Identifier: BSD-3-Clause
#
# The Debian packages, which the target package makes (CPack): one for each component of the installation, or that of the
# ParaView plugin. The root CMakeLists.txt includes this file when SURFACE_SYNTHESIS_PACKAGES is on; the preset `package` sets what belongs to it.
if (NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  message(FATAL_ERROR "SURFACE_SYNTHESIS_PACKAGES needs CMAKE_INSTALL_PREFIX=/usr; it is ${CMAKE_INSTALL_PREFIX}")
endif ()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME surfacesynthesis)
set(CPACK_PACKAGE_VENDOR "SurfaceSynthesis")
set(CPACK_PACKAGE_CONTACT "The SurfaceSynthesis developers <surfacesynthesis@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Generative filters on surfaces for VTK")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY "${CMAKE_BINARY_DIR}/packages")
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/SplitTraining.cmake")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(version "= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")
set(soversion "${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
set(library "libsurfacesynthesis${soversion}")
if (SURFACE_SYNTHESIS_PARAVIEW)
  include("${CMAKE_CURRENT_LIST_DIR}/PluginPackage.cmake")
  include(CPack)
  return()
endif ()
file(WRITE "${CMAKE_BINARY_DIR}/Debian/triggers" "activate-noawait ldconfig\n")

# surfsynth_add_package(<component> <name> <section> <summary> <description> [DEPENDS <text>...] [RECOMMENDS <text>...]
#   [SUGGESTS <text>...] [CONTROL <file>...] [ARCHITECTURE <name>])
macro (surfsynth_add_package component name section summary description)
  cmake_parse_arguments(arg "" "ARCHITECTURE" "DEPENDS;RECOMMENDS;SUGGESTS;CONTROL" ${ARGN})
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER "${component}" upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME "${name}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION "${section}")
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${description}")
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${description}")
  list(JOIN arg_DEPENDS ", " CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS)
  list(JOIN arg_RECOMMENDS ", " CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS)
  list(JOIN arg_SUGGESTS ", " CPACK_DEBIAN_${upper}_PACKAGE_SUGGESTS)
  set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA "${arg_CONTROL}")
  if (arg_ARCHITECTURE)
    set(CPACK_DEBIAN_${upper}_PACKAGE_ARCHITECTURE "${arg_ARCHITECTURE}")
    set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS OFF)
  endif ()
  install(FILES "${CMAKE_CURRENT_LIST_DIR}/copyright" DESTINATION "share/doc/${name}" COMPONENT ${component})
endmacro ()

surfsynth_add_package(models surfacesynthesis-models science "trained models of SurfaceSynthesis"
  "Shapes, signals, textures and geometric textures that the filters of SurfaceSynthesis know by their names."
  ARCHITECTURE all)
surfsynth_add_package(runtime ${library} libs "generative filters on surfaces for VTK, libraries"
  "Random fields, shapes, textures and geometric textures on triangle meshes, remeshing, repair and tetrahedra, as filters of VTK."
  DEPENDS "surfacesynthesis-models (${version})"
  CONTROL "${CMAKE_BINARY_DIR}/Debian/triggers")
set(development_needs
  "${library} (${version})" libeigen3-dev)
if (SURFACE_SYNTHESIS_VTK)
  list(APPEND development_needs libvtk9-dev)
endif ()
if (SURFACE_SYNTHESIS_LEARNING)
  surfsynth_add_package(training surfacesynthesis-training science "generative filters on surfaces for VTK, training"
    "Trainers of the models of SurfaceSynthesis, by LibTorch: the program surfacesynthesis-train, the filters and their Python module."
    DEPENDS "${library} (${version})"
    RECOMMENDS "python3-surfacesynthesis (${version})"
    CONTROL "${CMAKE_BINARY_DIR}/Debian/triggers")
  list(APPEND development_needs "surfacesynthesis-training (${version})" libtorch-dev)
endif ()
surfsynth_add_package(development libsurfacesynthesis-dev libdevel "generative filters on surfaces for VTK, development"
  "Headers and CMake package: find_package(SurfaceSynthesis)."
  DEPENDS ${development_needs})
if (SURFACE_SYNTHESIS_VTK AND SURFACE_SYNTHESIS_PYTHON)
  # Extension modules are of one version of Python.
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  foreach (script IN ITEMS postinst prerm)
    configure_file("${CMAKE_CURRENT_LIST_DIR}/python3-surfacesynthesis.${script}" "${CMAKE_BINARY_DIR}/Debian/${script}" COPYONLY
      FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endforeach ()
  surfsynth_add_package(python python3-surfacesynthesis python "generative filters on surfaces for VTK, Python and commands"
    "The Python package surfacesynthesis, and the command of the same name."
    DEPENDS "${library} (${version})" "python3 (>= 3.${Python3_VERSION_MINOR})" "python3 (<< 3.${next_minor})"
      python3-numpy python3-vtk9
    RECOMMENDS python3-gdcm python3-nibabel
    SUGGESTS "surfacesynthesis-training (${version})"
    CONTROL "${CMAKE_BINARY_DIR}/Debian/postinst;${CMAKE_BINARY_DIR}/Debian/prerm")
endif ()

include(CPack)
