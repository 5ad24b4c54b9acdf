# Installs the build into INSTALL_PREFIX, moves it to MOVED_PREFIX and checks what is there.

cmake_minimum_required(VERSION 3.16...3.25)

file(REMOVE_RECURSE "${INSTALL_PREFIX}" "${MOVED_PREFIX}")
execute_process(
  COMMAND ${CMAKE_COMMAND} --install "${BUILD_FOLDER}" --prefix "${INSTALL_PREFIX}"
    --config "${CONFIG}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "installation failed:\n${output}")
endif()
file(RENAME "${INSTALL_PREFIX}" "${MOVED_PREFIX}")

# Nothing that a consumer's CMake reads may know where the package was built or installed.
file(GLOB_RECURSE cmake_files "${MOVED_PREFIX}/*.cmake")
list(LENGTH cmake_files num_cmake_files)
list(LENGTH COMPONENTS num_components)
if(num_cmake_files LESS_EQUAL num_components)
  message(FATAL_ERROR "${num_cmake_files} CMake files for ${num_components} components")
endif()
foreach(file IN LISTS cmake_files)
  file(READ "${file}" text)
  foreach(folder "${BUILD_FOLDER}" "${PROJECT_FOLDER}" "${INSTALL_PREFIX}")
    string(FIND "${text}" "${folder}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${file} mentions ${folder}; the package cannot be moved")
    endif()
  endforeach()
endforeach()

# Every public header of an installed component is there, and no private one.
file(GLOB_RECURSE headers RELATIVE "${PROJECT_FOLDER}/include" "${PROJECT_FOLDER}/include/*.hpp")
set(num_headers 1)
if(NOT EXISTS "${MOVED_PREFIX}/include/srslam/version.hpp")
  message(FATAL_ERROR "include/srslam/version.hpp was not installed")
endif()
foreach(header IN LISTS headers)
  get_filename_component(name "${header}" NAME_WE)
  string(REGEX REPLACE "^srslam/([^/]+)/.*" "\\1" component "${header}")
  if(component STREQUAL "interop")
    # interop/<component>.hpp or interop/<component>_<what>.hpp; optical flow is OpenCV's.
    string(REGEX REPLACE "^(corner_pyramid|lucas_kanade|follow_reference|scene_flow)$" "opencv"
                         component "${name}")
    string(REGEX REPLACE "_.*" "" component "${component}")
  elseif(component STREQUAL header)
    set(component srslam)
  endif()
  if(component IN_LIST COMPONENTS)
    math(EXPR num_headers "${num_headers} + 1")
    if(NOT EXISTS "${MOVED_PREFIX}/include/${header}")
      message(FATAL_ERROR "include/${header} was not installed")
    endif()
  endif()
endforeach()
file(GLOB_RECURSE installed_headers "${MOVED_PREFIX}/include/*")
list(LENGTH installed_headers num_installed_headers)
if(NOT num_installed_headers EQUAL num_headers)
  message(FATAL_ERROR "${num_installed_headers} files in include/, ${num_headers} expected:\n"
                      "${installed_headers}")
endif()
message(STATUS "installed and moved: ${num_headers} headers, ${num_cmake_files} CMake files")
