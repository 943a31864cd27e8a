# The Python package tetfusion, which calls the library by its C interface: nothing to compile, for any Python with NumPy.
set(TETFUSION_PYTHON_DESTINATION lib/python3/dist-packages
    CACHE INTERNAL "Where Python packages go, in the build as below the prefix")
# FOLDER's files, and those that packages share, as the package NAME in DESTINATION, in the build as below the prefix. With
# one more argument, the version of VTK that its module is built with, it knows that.
function(add_python_package name folder destination component)
  set(package ${destination}/${name})
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*.py)
  foreach(file ${files})
    cmake_path(GET file FILENAME as)
    configure_file(${file} ${CMAKE_BINARY_DIR}/${package}/${as} COPYONLY)
  endforeach()
  set(shared ${CMAKE_SOURCE_DIR}/src/python/option_values.py)
  configure_file(${shared} ${CMAKE_BINARY_DIR}/${package}/_option_values.py COPYONLY)
  install(FILES ${files} DESTINATION ${package} COMPONENT ${component})
  install(FILES ${shared} DESTINATION ${package} RENAME _option_values.py COMPONENT ${component})
  if(ARGC GREATER 4)
    set(built_with ${CMAKE_BINARY_DIR}/${package}/_built_with.py)
    file(CONFIGURE OUTPUT ${built_with} CONTENT "VTK = \"${ARGV4}\"\n")
    install(FILES ${built_with} DESTINATION ${package} COMPONENT ${component})
  endif()
endfunction()
add_python_package(tetfusion ${CMAKE_CURRENT_LIST_DIR}/tetfusion ${TETFUSION_PYTHON_DESTINATION} numpy)
