# Manual pages, one for each command, made of what --help says; without help2man there are none.
# To be set: TETFUSION_COMMANDS.
find_program(HELP2MAN help2man)
if(NOT HELP2MAN)
  message(STATUS "help2man was not found: no manual pages will be made")
  return()
endif()
if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
  message(STATUS "The command cannot run here (CMAKE_CROSSCOMPILING_EMULATOR): no manual pages will be made")
  return()
endif()

set(folder ${CMAKE_BINARY_DIR}/man)
set(also "[SEE ALSO]\n.BR tetfusion (1)")
foreach(command ${TETFUSION_COMMANDS})
  string(APPEND also ",\n.BR tetfusion-${command} (1)")
endforeach()
file(READ ${CMAKE_CURRENT_LIST_DIR}/man.inc exit_status)
file(CONFIGURE OUTPUT ${folder}/man.inc CONTENT "${exit_status}\n${also}\n" @ONLY)

# help2man calls a page after the program it asks. What it is for is the first line of --help.
list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
set(pages "")
foreach(command "" ${TETFUSION_COMMANDS})
  string(REGEX REPLACE "(.+)" "-\\1" dashed "${command}")
  set(program ${folder}/tetfusion${dashed})
  file(CONFIGURE OUTPUT ${program} CONTENT "#!/bin/sh\nexec ${emulator} ${CMAKE_BINARY_DIR}/tetfusion ${command} \"$@\"\n" @ONLY)
  file(CHMOD ${program} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  add_custom_command(
    OUTPUT ${program}.1
    COMMAND sh -c "name=$('${program}' --help | sed '1s/^./\\l&/;q') && exec \"$0\" --name \"$name\" \"$@\""
            ${HELP2MAN} --no-info --version-string=${PROJECT_VERSION} --include ${folder}/man.inc --output ${program}.1 ${program}
    DEPENDS tetfusion ${folder}/man.inc ${program}
    COMMENT "Making the page tetfusion${dashed}(1)" VERBATIM)
  list(APPEND pages ${program}.1)
endforeach()
add_custom_target(man ALL DEPENDS ${pages})
install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT command)
