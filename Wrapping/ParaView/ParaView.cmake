# SPDX-License-Identifier: BSD-3-Clause
#
# The ParaView plugin: the same modules as in a build against VTK, built against the VTK inside ParaView. The root
# CMakeLists.txt includes this file, when SURFACE_SYNTHESIS_PARAVIEW is on, in place of its own find_package(VTK): both
# VTKs define targets of the same names, so each needs a build tree of its own.
#
# Set ParaView_DIR to <prefix>/lib/.../cmake/paraview-5.11.

# ----------------------------------------------------------------------------------------------------------------------
# ParaView, its VTK, and Qt for the widgets of the property panel.

enable_language(C) # ParaView looks for MPI's C library
# Without COMPONENTS, the development files of Qt would be required.
find_package(ParaView 5.11 REQUIRED COMPONENTS RemotingCore RemotingServerManager)

set(components CommonCore CommonDataModel CommonExecutionModel FiltersCore FiltersModeling ParallelCore)
find_package(Python3 COMPONENTS Interpreter Development.Module)
if (SURFACE_SYNTHESIS_PYTHON AND Python3_Development.Module_FOUND)
  set(surfsynth_wrap_python ON)
  list(APPEND components Python WrappingPythonCore WrappingTools)
else ()
  set(surfsynth_wrap_python OFF)
endif ()
find_package(VTK REQUIRED COMPONENTS ${components} PATHS "${ParaView_DIR}/vtk" NO_DEFAULT_PATH)

set(surfsynth_widgets OFF)
if (PARAVIEW_USE_QT)
  find_package(Qt5 QUIET COMPONENTS Core Widgets)
  if (Qt5_FOUND AND TARGET ParaView::pqComponents)
    set(surfsynth_widgets ON)
    # The link interface of ParaView's widget libraries names all libraries of its build (HDF5, NetCDF, GLEW, ...).
    # A plugin needs the development files of none of them: ParaView itself provides their symbols.
    set_target_properties(ParaView::pqComponents ParaView::pqCore PROPERTIES
      INTERFACE_LINK_LIBRARIES Qt5::Widgets
      IMPORTED_LINK_DEPENDENT_LIBRARIES_DEBUG "")
  else ()
    message(STATUS "The development files of Qt 5 (Debian: qtbase5-dev) were not found: the plugin is built without icons "
      "and without widgets of its own")
  endif ()
endif ()

# ----------------------------------------------------------------------------------------------------------------------
# The plugin with its modules. An installed plugin finds ParaView's libraries at their present paths: pvpython, unlike
# paraview, has not loaded those of the widgets.
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)
# Modules with filters. The bridge between them and the core is not for users, and is not wrapped in Python.
include("${CMAKE_CURRENT_SOURCE_DIR}/Filters/MeshProcessing/Options.cmake")
set(surfsynth_filter_modules
  VTK::SurfaceSynthesisEnsembles
  VTK::SurfaceSynthesisFieldLatents
  VTK::SurfaceSynthesisFlowMatching
  VTK::SurfaceSynthesisGeometricTexture
  VTK::SurfaceSynthesisMeshing
  VTK::SurfaceSynthesisNoise
  VTK::SurfaceSynthesisPoissonNet
  VTK::SurfaceSynthesisStatistics)
if (SURFACE_SYNTHESIS_LEARNING)
  list(APPEND surfsynth_filter_modules VTK::SurfaceSynthesisTraining)
endif ()
set(surfsynth_plugin_modules
  VTK::SurfaceSynthesisBridge
  ${surfsynth_filter_modules})
vtk_module_find_modules(surfsynth_plugin_module_files "${CMAKE_CURRENT_SOURCE_DIR}/Filters")

paraview_plugin_scan(
  PLUGIN_FILES "${CMAKE_CURRENT_LIST_DIR}/paraview.plugin"
  PROVIDES_PLUGINS plugins
  REQUIRES_MODULES required_modules
  ENABLE_BY_DEFAULT ON)
foreach (module IN LISTS required_modules)
  if (NOT TARGET "${module}")
    message(FATAL_ERROR "This ParaView ${ParaView_VERSION} lacks the module ${module}, which the plugin needs")
  endif ()
endforeach ()

paraview_plugin_build(
  PLUGINS ${plugins}
  LIBRARY_SUBDIRECTORY "${PARAVIEW_PLUGIN_SUBDIR}"
  PLUGINS_FILE_NAME surfacesynthesis.plugins.xml
  INSTALL_HEADERS OFF
  DISABLE_XML_DOCUMENTATION ON)
surfsynth_set_warnings(${surfsynth_plugin_modules})

# The folder of the plugin's libraries, below the build folder and below the installation prefix. PV_PLUGIN_PATH may
# name it.
set(surfsynth_plugin_destination "${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}/SurfaceSynthesis")
# The list of plugins that names this one: in paraview.conf ParaView knows it by its name, as PV_PLUGIN_CONFIG_FILE loads it.
set(surfsynth_plugins_file "${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}/surfacesynthesis.plugins.xml")

# ----------------------------------------------------------------------------------------------------------------------
# The Python package, for pvpython.
if (surfsynth_wrap_python)
  vtk_module_wrap_python(
    MODULES ${surfsynth_filter_modules}
    PYTHON_PACKAGE surfacesynthesis
    MODULE_DESTINATION "${surfsynth_python_destination}"
    LIBRARY_DESTINATION "${surfsynth_plugin_destination}"
    CMAKE_DESTINATION "${surfsynth_cmake_destination}"
    INSTALL_HEADERS OFF)
  add_subdirectory(Wrapping/Python)
endif ()
