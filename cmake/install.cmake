# The library that others embed: all rooms but the program's own in one shared object, found with find_package(tellurion).
# Its headers need GLM and tl::expected; every other library stays inside.
include(CMakePackageConfigHelpers)

set(tellurion_rooms geo tiling io raster pyramid scene render)
foreach(room IN LISTS tellurion_rooms)
  list(APPEND tellurion_room_targets tellurion_${room})
  list(APPEND tellurion_room_objects $<TARGET_OBJECTS:tellurion_${room}>)
endforeach()

# The rooms' objects go in whole; linking the rooms too brings the libraries behind their walls.
add_library(tellurion_library SHARED ${tellurion_room_objects})
set_target_properties(tellurion_library PROPERTIES
  OUTPUT_NAME tellurion EXPORT_NAME tellurion VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}
  LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib LINKER_LANGUAGE CXX)
target_link_libraries(tellurion_library PRIVATE ${tellurion_room_targets} INTERFACE glm::glm tl::expected)
target_include_directories(tellurion_library INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/tellurion>)
target_compile_features(tellurion_library INTERFACE cxx_std_20)

install(TARGETS tellurion_library EXPORT tellurionTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT tellurionTargets NAMESPACE tellurion:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tellurion)
foreach(room IN LISTS tellurion_rooms)
  install(DIRECTORY src/${room} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tellurion FILES_MATCHING PATTERN "*.h" PATTERN "*_test.h" EXCLUDE)
endforeach()
configure_package_config_file(cmake/tellurionConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/tellurionConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tellurion)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/tellurionConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/tellurionConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/tellurionConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/tellurion)
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
