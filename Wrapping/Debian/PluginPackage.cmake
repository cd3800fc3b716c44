# SPDX-License-Identifier: BSD-3-Clause
#
# The Debian package of the ParaView plugin, which the target package makes (CPack). Packages.cmake includes this file in a build
# with SURFACE_SYNTHESIS_PARAVIEW: the plugin is built against ParaView's own VTK, in a build tree of its own (preset
# `package-paraview`). Libraries without VTK, the program for tetrahedra and the models are those of the package of the library.
if (SURFACE_SYNTHESIS_LEARNING)
  message(FATAL_ERROR "The package of the plugin is built with -DSURFACE_SYNTHESIS_LEARNING=OFF: the plugin would need LibTorch")
endif ()
set(CPACK_DEB_COMPONENT_INSTALL OFF)
set(CPACK_COMPONENTS_ALL)
set(CPACK_MONOLITHIC_INSTALL ON)
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/KeepPlugin.cmake")
set(CPACK_DEBIAN_PACKAGE_NAME paraview-surfacesynthesis)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# ParaView need not be installed where the package is made, so that its dependencies are named here.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS OFF)
# Folders and names of its libraries are those of one series.
string(REGEX MATCH "^([0-9]+)\\.([0-9]+)" paraview_series "${ParaView_VERSION}")
math(EXPR next_minor "${CMAKE_MATCH_2} + 1")
set(CPACK_DEBIAN_PACKAGE_DEPENDS "${library} (${version}), paraview (>= ${paraview_series}), \
paraview (<< ${CMAKE_MATCH_1}.${next_minor}), libc6, libgcc-s1, libstdc++6")
foreach (script IN ITEMS postinst prerm)
  configure_file("${CMAKE_CURRENT_LIST_DIR}/paraview-surfacesynthesis.${script}" "${CMAKE_BINARY_DIR}/Debian/${script}" @ONLY
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  list(APPEND CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA "${CMAKE_BINARY_DIR}/Debian/${script}")
endforeach ()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "generative filters on surfaces, plugin of ParaView")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
  "The filters of SurfaceSynthesis in ParaView: random fields, shapes, textures, remeshing, repair and tetrahedra. Trainings are not in this package.")
install(FILES "${CMAKE_CURRENT_LIST_DIR}/copyright" DESTINATION "share/doc/paraview-surfacesynthesis")
