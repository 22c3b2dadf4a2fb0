# GoogleTest's suites as tests of CTest: a process a suite, not one a case, since to start one takes longer than most cases do. Suites that take long
# have a process a parameter, or a case where there is none, and begin first.
#   tellurion_suites(TARGET PREFIX room. [LONG suite ...] [ARGUMENTS argument ...])
function(tellurion_suites target)
  cmake_parse_arguments(SUITES "" "PREFIX" "LONG;ARGUMENTS" ${ARGN})
  set(list ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
  add_custom_command(TARGET ${target} POST_BUILD BYPRODUCTS ${list} VERBATIM
    COMMAND ${CMAKE_COMMAND} "-DPROGRAM=$<TARGET_FILE:${target}>" "-DPREFIX=${SUITES_PREFIX}" "-DLONG=${SUITES_LONG}"
      "-DARGUMENTS=${SUITES_ARGUMENTS}" "-DFOLDER=${CMAKE_CURRENT_BINARY_DIR}" "-DLIST=${list}" -P ${PROJECT_SOURCE_DIR}/cmake/list_suites.cmake)
  set(include ${CMAKE_CURRENT_BINARY_DIR}/${target}_include.cmake)
  file(WRITE ${include} "if(EXISTS \"${list}\")\n  include(\"${list}\")\nelse()\n  add_test(${SUITES_PREFIX}NOT_BUILT ${target}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include})
endfunction()
