# A room is a folder under src/, a static library, a namespace and an include prefix. Its sources are the folder's *.cpp, its
# tests the *_test.cpp beside them.
#   tellurion_room(NAME [PUBLIC target ...] [PRIVATE target ...])
function(tellurion_room name)
  cmake_parse_arguments(ROOM "" "" "PUBLIC;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  add_library(tellurion_${name} STATIC ${sources})
  target_include_directories(tellurion_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>)
  target_link_libraries(tellurion_${name} PUBLIC ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE} $<BUILD_INTERFACE:tellurion_warnings>)
  # Half of what compiling a source takes is to read these. Builds with sanitizers go without, so that an include that is
  # missing is found (without TELLURION_UNITY, that is).
  if(NOT TELLURION_SANITIZE)
    target_precompile_headers(tellurion_${name} PRIVATE
      <algorithm> <array> <cmath> <functional> <map> <memory> <optional> <span> <string> <unordered_map> <vector>
      "${PROJECT_SOURCE_DIR}/src/geo/vector.h")
    # What g++ 12 sees inside inlined strings is not there (GCC bug 105329); from precompiled headers it tells it.
    target_compile_options(tellurion_${name} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>")
  endif()
  tellurion_unity(tellurion_${name})
endfunction()

# Tests are told where the real data lies, if it is there; a test that needs it says GTEST_SKIP when it is not.
#   tellurion_room_tests(NAME [LINK target ...] [LONG suite ...])   LONG: suites with more processes than one (suites.cmake)
function(tellurion_room_tests name)
  if(NOT TELLURION_TESTS)
    return()
  endif()
  cmake_parse_arguments(TEST "" "" "LINK;LONG" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(${name}_tests ${sources})
  target_link_libraries(${name}_tests PRIVATE tellurion_${name} ${TEST_LINK} GTest::gtest GTest::gmock GTest::gtest_main
                        tellurion_warnings)
  target_compile_definitions(${name}_tests PRIVATE
    TELLURION_SOURCE_DIR="${PROJECT_SOURCE_DIR}" TELLURION_SHARED_DATA_DIR="${PROJECT_SOURCE_DIR}/../shared/data")
  # Tests are half of what there is to compile: GoogleTest's headers are read once, and the tests' own code need not be fast.
  target_precompile_headers(${name}_tests PRIVATE <gmock/gmock.h> <gtest/gtest.h>)
  # At -O1 g++ 12 sees overruns inside inlined strings that are not there (GCC bug 105329).
  target_compile_options(${name}_tests PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O1> "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow>")
  tellurion_unity(${name}_tests)
  tellurion_suites(${name}_tests PREFIX ${name}. LONG ${TEST_LONG})
endfunction()
