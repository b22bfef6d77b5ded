# Libraries whose own CMake files are missing or awkward on Debian 12, as targets. Used by the build and, installed beside
# calotConfig.cmake, by the projects that use Calot.

# A library found by a header and a name.
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

# CHOLMOD and OpenBLAS ship no usable CMake files.
macro(calot_find_blas_and_cholmod)
  calot_find_library(calot_cholmod cholmod.h cholmod SUFFIXES suitesparse)
  calot_find_library(calot_openblas openblas_config.h openblas SUFFIXES openblas-pthread openblas)
endmacro()

# What decodes compressed DICOM: OpenJPEG (JPEG 2000), and GDCM (JPEG, JPEG-LS), which comes with ITK.
function(calot_find_dicom_codecs)
  if(TARGET calot_dicom_codecs)
    return()
  endif()
  calot_find_library(calot_openjpeg openjpeg.h openjp2 SUFFIXES openjpeg-2.5)
  add_library(calot_dicom_codecs INTERFACE IMPORTED GLOBAL)
  target_link_libraries(calot_dicom_codecs INTERFACE calot_openjpeg)
  foreach(part MSFF DSED DICT Common)
    calot_find_library(calot_gdcm_${part} gdcmReader.h gdcm${part} SUFFIXES gdcm-3.0)
    target_link_libraries(calot_dicom_codecs INTERFACE calot_gdcm_${part})
  endforeach()
endfunction()

# ITK is the judge of images in the tests. Its package file fills variables (and overwrites HDF5's), so it is kept in a
# function and the parts we use become one target of ours. Debian's file also looks for the programs of libgdcm-tools
# and libvtkgdcm-tools.
function(calot_find_itk)
  calot_find_dicom_codecs()
  if(TARGET calot_itk)
    return()
  endif()
  find_package(ITK 5.2 REQUIRED COMPONENTS ITKCommon ITKIOImageBase ITKIONIFTI ITKIONRRD ITKIOGDCM)
  add_library(calot_itk INTERFACE IMPORTED GLOBAL)
  target_include_directories(calot_itk SYSTEM INTERFACE ${ITK_INCLUDE_DIRS})
  target_link_libraries(calot_itk INTERFACE ${ITK_LIBRARIES})
endfunction()

# Siconos judges the friction solver in tests and benchmarks. It ships no CMake files; its headers name each other with
# and without their folder.
function(calot_find_siconos)
  calot_find_library(calot_siconos_numerics siconos/numerics/NonSmoothDrivers.h siconos_numerics)
  target_include_directories(calot_siconos_numerics SYSTEM INTERFACE
    ${calot_siconos_numerics_INCLUDE_DIR}/siconos ${calot_siconos_numerics_INCLUDE_DIR}/siconos/numerics)
endfunction()
