# The plugin TetFusion for ParaView, the filter's Python package for ParaView's Python, and the script for several
# processes. They need ParaView's own VTK: a build tree of its own. All go to one folder, with the library.
include(CheckLanguage)
check_language(C)
if(NOT CMAKE_C_COMPILER)
  message(FATAL_ERROR "TETFUSION_PARAVIEW_PLUGIN is ON, but there is no C compiler, with which ParaView's packages are looked for")
endif()
enable_language(C)
set(components RemotingCore WrapClientServer ProcessXML)  # without a list all are wanted, those of the window too
find_package(ParaView 5.11 QUIET COMPONENTS ${components})
if(NOT ParaView_FOUND)
  message(FATAL_ERROR "TETFUSION_PARAVIEW_PLUGIN is ON, but ParaView 5.11 or newer was not found: set ParaView_DIR to the folder "
                      "of its paraview-config.cmake (README.md, ParaView). ${ParaView_NOT_FOUND_MESSAGE}")
endif()

set(BUILD_SHARED_LIBS ON)
set(CMAKE_INSTALL_RPATH "$ORIGIN")  # the library lies beside the filter and the plugin
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR})  # the build tree as the installed one
set(TETFUSION_PARAVIEW_DESTINATION ${CMAKE_INSTALL_LIBDIR}/${PARAVIEW_PLUGIN_SUBDIR}/TetFusion)
paraview_plugin_scan(
  PLUGIN_FILES ${CMAKE_CURRENT_LIST_DIR}/paraview.plugin
  PROVIDES_PLUGINS tetfusion_paraview_plugins
  ENABLE_BY_DEFAULT ON
  HIDE_PLUGINS_FROM_CACHE ON)
paraview_plugin_build(
  PLUGINS ${tetfusion_paraview_plugins}
  PLUGINS_COMPONENT paraview
  INSTALL_HEADERS OFF
  LIBRARY_SUBDIRECTORY ${PARAVIEW_PLUGIN_SUBDIR})
install(TARGETS tetfusion_library
        LIBRARY DESTINATION ${TETFUSION_PARAVIEW_DESTINATION} NAMELINK_SKIP COMPONENT paraview)

# With pvbatch's own Python, which is the system's.
find_program(TETFUSION_VTK_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
set(Python3_EXECUTABLE ${TETFUSION_VTK_PYTHON})
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
find_package(VTK QUIET PATHS ${ParaView_DIR}/vtk NO_DEFAULT_PATH COMPONENTS CommonExecutionModel WrappingPythonCore Python)
if(NOT TARGET VTK::WrapPython OR NOT TARGET VTK::WrappingPythonCore OR NOT Python3_Development.Module_FOUND)
  message(FATAL_ERROR "ParaView's Python wrapping, or Python's headers, were not found (Debian: apt install python3-dev)")
endif()
set(python ${TETFUSION_PARAVIEW_DESTINATION}/python)
vtk_module_wrap_python(
  MODULES TetFusion::Filter
  TARGET TetFusionPython
  PYTHON_PACKAGE vtktetfusion
  MODULE_DESTINATION ${python}
  LIBRARY_DESTINATION ${TETFUSION_PARAVIEW_DESTINATION}
  BUILD_STATIC OFF
  INSTALL_HEADERS OFF
  COMPONENT paraview)
add_python_package(vtktetfusion ${CMAKE_CURRENT_LIST_DIR}/../filter/python ${python} paraview
                   ${VTK_MAJOR_VERSION}.${VTK_MINOR_VERSION})

# The script finds its modules in the package beside it.
file(GLOB modules CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_LIST_DIR} ${CMAKE_CURRENT_LIST_DIR}/tetfusion_ranks/*.py)
foreach(file distributed.py ${modules})
  get_filename_component(folder ${file} DIRECTORY)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${file} ${CMAKE_BINARY_DIR}/${python}/${file} COPYONLY)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/${file} DESTINATION ${python}/${folder} COMPONENT paraview)
endforeach()
