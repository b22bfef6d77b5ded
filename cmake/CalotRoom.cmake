# calot_room(NAME SOURCES … PUBLIC … PRIVATE …): a folder of calot/ as a target, calot::NAME.
# What it links is what it may include: rooms named here are the only ones whose headers it may use.
function(calot_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(calot_${name} STATIC ${ROOM_SOURCES})
  add_library(calot::${name} ALIAS calot_${name})
  set_target_properties(calot_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(calot_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(calot_${name} PUBLIC cxx_std_20)
  calot_warnings(calot_${name})
  # Headers only, so nobody needs them again to link.
  set(headers_only toml11::toml11 nlohmann_json::nlohmann_json Boost::headers)
  foreach(library IN LISTS ROOM_PRIVATE)
    if(library IN_LIST headers_only)
      target_link_libraries(calot_${name} PRIVATE $<BUILD_INTERFACE:${library}>)
    else()
      target_link_libraries(calot_${name} PRIVATE ${library})
    endif()
  endforeach()
  target_link_libraries(calot_${name} PUBLIC ${ROOM_PUBLIC})
  set_property(GLOBAL APPEND PROPERTY CALOT_ROOMS calot_${name})
endfunction()

# The same bits in every preset: no contraction of a*b+c into one rounding behind our back.
function(calot_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -ffp-contract=off -fno-math-errno)
  if(CALOT_CHECKED)
    target_compile_definitions(${target} PRIVATE CALOT_CHECKED=1)
  endif()
endfunction()
