# Every library Calot is built on, found in one place. All are Debian 12 packages; `./dev setup` installs them.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(spdlog REQUIRED)
find_package(pugixml REQUIRED)
find_package(toml11 3.7 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(HDF5 1.10 REQUIRED COMPONENTS C)

# CHOLMOD and OpenBLAS ship no usable CMake files in Debian 12.
function(calot_find_library target header library)
  cmake_parse_arguments(F "" "" "SUFFIXES" ${ARGN})
  find_path(${target}_INCLUDE_DIR ${header} REQUIRED PATH_SUFFIXES ${F_SUFFIXES}
    PATHS /usr/include /usr/include/${CMAKE_LIBRARY_ARCHITECTURE})
  find_library(${target}_LIBRARY ${library} REQUIRED PATH_SUFFIXES ${F_SUFFIXES})
  mark_as_advanced(${target}_INCLUDE_DIR ${target}_LIBRARY)
  if(NOT TARGET ${target})
    add_library(${target} UNKNOWN IMPORTED GLOBAL)
    set_target_properties(${target} PROPERTIES IMPORTED_LOCATION ${${target}_LIBRARY})
    target_include_directories(${target} SYSTEM INTERFACE ${${target}_INCLUDE_DIR})
  endif()
endfunction()
calot_find_library(calot_cholmod cholmod.h cholmod SUFFIXES suitesparse)
calot_find_library(calot_openblas openblas_config.h openblas SUFFIXES openblas-pthread openblas)

# CGAL meshes label maps; header-only.
find_package(CGAL 5.5 REQUIRED)
# ITK reads medical images. Its package file fills variables (and overwrites HDF5's), so it is kept in a function and the
# parts we use become one target of ours. Debian's file also looks for the programs of libgdcm-tools and libvtkgdcm-tools.
function(calot_find_itk)
  find_package(ITK 5.2 REQUIRED COMPONENTS ITKCommon ITKIOImageBase ITKIONIFTI)
  add_library(calot_itk INTERFACE IMPORTED GLOBAL)
  target_include_directories(calot_itk SYSTEM INTERFACE ${ITK_INCLUDE_DIRS})
  target_link_libraries(calot_itk INTERFACE ${ITK_LIBRARIES})
endfunction()
calot_find_itk()
