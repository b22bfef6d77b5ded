# `cmake --install` and `find_package(calot)`. The rooms of calot::calot are always there; patient and picture, which need
# more libraries, are components: find_package(calot COMPONENTS patient picture).
include(CMakePackageConfigHelpers)

set(calot_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/calot)

# Public headers keep their folders; those marked "Inside this room only" or "Inside the library only" stay at home.
function(calot_install_headers)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/calot/*.h)
  # What the program alone uses so far isn't installed.
  list(FILTER headers EXCLUDE REGEX "^calot/(view|sound|device)/")
  foreach(header IN LISTS headers)
    file(STRINGS ${PROJECT_SOURCE_DIR}/${header} first LIMIT_COUNT 1)
    if(NOT first MATCHES "^// Inside (this room|the library) only")
      get_filename_component(folder ${header} DIRECTORY)
      install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
    endif()
  endforeach()
endfunction()

function(calot_install_targets export)
  install(TARGETS ${ARGN} EXPORT ${export}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT ${export} NAMESPACE calot:: DESTINATION ${calot_package_dir})
endfunction()

function(calot_install)
  get_property(rooms GLOBAL PROPERTY CALOT_ROOMS)
  list(REMOVE_ITEM rooms calot_image calot_patient calot_scene calot_picture calot_view calot_sound calot_device)
  calot_install_targets(calotTargets ${rooms} calot)
  calot_install_targets(calotPatientTargets calot_image calot_patient calot_scene)
  calot_install_targets(calotPictureTargets calot_picture)
  calot_install_headers()
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/calotConfig.cmake.in
    ${PROJECT_BINARY_DIR}/calotConfig.cmake INSTALL_DESTINATION ${calot_package_dir})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/calotConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/calotConfig.cmake ${PROJECT_BINARY_DIR}/calotConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/CalotLibraries.cmake DESTINATION ${calot_package_dir})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
endfunction()
