# The Python package tetfusion, which calls the library by its C interface: nothing to compile, for any Python with NumPy.
set(TETFUSION_PYTHON_DESTINATION lib/python3/dist-packages
    CACHE INTERNAL "Where Python packages go, in the build as below the prefix")
# FOLDER's files, and those that packages share, as the package NAME.
function(add_python_package name folder component)
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*.py)
  foreach(file ${files})
    cmake_path(GET file FILENAME as)
    configure_file(${file} ${CMAKE_BINARY_DIR}/${TETFUSION_PYTHON_DESTINATION}/${name}/${as} COPYONLY)
  endforeach()
  set(shared ${CMAKE_SOURCE_DIR}/src/python/option_values.py)
  configure_file(${shared} ${CMAKE_BINARY_DIR}/${TETFUSION_PYTHON_DESTINATION}/${name}/_option_values.py COPYONLY)
  install(FILES ${files} DESTINATION ${TETFUSION_PYTHON_DESTINATION}/${name} COMPONENT ${component})
  install(FILES ${shared} DESTINATION ${TETFUSION_PYTHON_DESTINATION}/${name} RENAME _option_values.py
          COMPONENT ${component})
endfunction()
add_python_package(tetfusion ${CMAKE_CURRENT_LIST_DIR}/tetfusion numpy)
