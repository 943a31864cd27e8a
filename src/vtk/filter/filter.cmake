# The filter vtkTetFusion as a VTK module, and the Python package vtktetfusion. TETFUSION_VTK_FILTER: ON fails without
# VTK's tools for Python, AUTO goes without the package.
set(BUILD_SHARED_LIBS ON)
set(CMAKE_INSTALL_RPATH "$ORIGIN")  # the library lies beside the filter
vtk_module_scan(
  MODULE_FILES ${CMAKE_CURRENT_LIST_DIR}/vtk.module
  REQUEST_MODULES TetFusion::Filter
  PROVIDES_MODULES tetfusion_vtk_modules
  HIDE_MODULES_FROM_CACHE ON
  ENABLE_TESTS OFF)
vtk_module_build(
  MODULES ${tetfusion_vtk_modules}
  PACKAGE TetFusionVTK
  INSTALL_EXPORT TetFusionVTKTargets
  LIBRARY_DESTINATION ${CMAKE_INSTALL_LIBDIR}
  HEADERS_DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  CMAKE_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/TetFusionVTK
  TARGETS_COMPONENT vtk
  HEADERS_COMPONENT vtk)
set(version_file ${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}/cmake/TetFusionVTK/TetFusionVTKConfigVersion.cmake)
write_basic_package_version_file(${version_file} COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/TetFusionVTKConfig.cmake ${version_file}
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/TetFusionVTK COMPONENT vtk)

# The system's Python: another one on the PATH has no vtkmodules.
find_program(TETFUSION_VTK_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
set(Python3_EXECUTABLE ${TETFUSION_VTK_PYTHON})
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
find_package(VTK QUIET COMPONENTS CommonExecutionModel WrappingPythonCore Python)
if(NOT TARGET VTK::WrapPython OR NOT TARGET VTK::WrappingPythonCore OR NOT Python3_Development.Module_FOUND)
  if(TETFUSION_VTK_FILTER STREQUAL "ON")
    message(FATAL_ERROR "TETFUSION_VTK_FILTER is ON, but VTK's Python wrapping was not found "
                        "(Debian: apt install libvtk9-dev python3-vtk9)")
  endif()
  message(STATUS "VTK's Python wrapping was not found: there will be no Python package")
  return()
endif()
vtk_module_wrap_python(
  MODULES ${tetfusion_vtk_modules}
  TARGET TetFusionPython
  PYTHON_PACKAGE vtktetfusion
  MODULE_DESTINATION ${TETFUSION_PYTHON_DESTINATION}
  LIBRARY_DESTINATION ${CMAKE_INSTALL_LIBDIR}
  BUILD_STATIC OFF
  INSTALL_HEADERS OFF
  COMPONENT python)
add_python_package(vtktetfusion ${CMAKE_CURRENT_LIST_DIR}/python ${TETFUSION_PYTHON_DESTINATION} python
                   ${VTK_MAJOR_VERSION}.${VTK_MINOR_VERSION})
