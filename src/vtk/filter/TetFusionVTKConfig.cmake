# find_package(TetFusionVTK) gives TetFusion::Filter, the VTK module with vtkTetFusion.
include(CMakeFindDependencyMacro)
find_dependency(TetFusion)
find_dependency(VTK COMPONENTS CommonCore CommonDataModel CommonExecutionModel CommonMisc)
include(${CMAKE_CURRENT_LIST_DIR}/TetFusionVTK-targets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/TetFusionVTK-vtk-module-properties.cmake)
