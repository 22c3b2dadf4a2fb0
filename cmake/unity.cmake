# Compiling several sources as one takes a third to a half less of the processor's time, and more of it again after each edit: ./bootstrap asks for it, the presets do
# not. The files keep names for themselves alone, so those that would clash are kept apart (unity_groups.py).
option(TELLURION_UNITY "Compile sources in groups: for builds from nothing" OFF)
if(TELLURION_UNITY)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
endif()

#   tellurion_unity(TARGET [LINES lines of a group])
function(tellurion_unity target)
  if(NOT TELLURION_UNITY)
    return()
  endif()
  cmake_parse_arguments(UNITY "" "LINES" "" ${ARGN})
  if(NOT UNITY_LINES)
    set(UNITY_LINES 2500)
  endif()
  get_target_property(sources ${target} SOURCES)
  list(TRANSFORM sources PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ REGEX "^[^/]")
  execute_process(COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/unity_groups.py ${UNITY_LINES} ${sources}
    OUTPUT_VARIABLE groups COMMAND_ERROR_IS_FATAL ANY)
  foreach(source group IN ZIP_LISTS sources groups)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${target}_${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # A class of a header is finished in a source, which no longer is one of its own.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  # A new name may clash.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${sources} ${PROJECT_SOURCE_DIR}/cmake/unity_groups.py)
endfunction()
