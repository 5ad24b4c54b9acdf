# Finds the libraries that srslam builds on, one by one and by name. The build and the installed
# package configuration both use this file, so that they ask for the same things.
#
# A library is written as a specification, `Name` or `Name:module,module`, for example `Eigen3` or
# `OpenCV:core,imgproc`.

# Not part of the interface: `OpenCV:core,imgproc` is OpenCV with the modules core;imgproc.
function(_srslam_split_specification specification out_name out_modules)
  set(name "${specification}")
  set(modules)
  if(specification MATCHES "^([^:]+):(.+)$")
    set(name "${CMAKE_MATCH_1}")
    string(REPLACE "," ";" modules "${CMAKE_MATCH_2}")
  endif()
  set(${out_name} "${name}" PARENT_SCOPE)
  set(${out_modules} "${modules}" PARENT_SCOPE)
endfunction()

# srslam_dependency_targets(<specification> <out-variable>)
#
# The imported targets that a specification stands for.
function(srslam_dependency_targets specification out_targets)
  _srslam_split_specification("${specification}" name modules)
  set(targets)
  if(name STREQUAL "OpenCV")
    foreach(module IN LISTS modules)
      list(APPEND targets opencv_${module})
    endforeach()
  elseif(name STREQUAL "Eigen3")
    set(targets Eigen3::Eigen)
  elseif(name STREQUAL "Ceres")
    set(targets Ceres::ceres)
  elseif(name STREQUAL "nanoflann")
    set(targets nanoflann::nanoflann)
  elseif(name STREQUAL "Threads")
    set(targets Threads::Threads)
  elseif(name STREQUAL "CLI11")
    set(targets CLI11::CLI11)
  elseif(name STREQUAL "nlohmann_json")
    set(targets nlohmann_json::nlohmann_json)
  elseif(name STREQUAL "GTest")
    set(targets GTest::gtest GTest::gtest_main GTest::gmock)
  elseif(name STREQUAL "benchmark")
    set(targets benchmark::benchmark benchmark::benchmark_main)
  endif()
  if(NOT targets)
    message(FATAL_ERROR "srslam: '${specification}' is not a library that srslam knows; "
                        "add it to SrslamDependencies.cmake")
  endif()
  set(${out_targets} ${targets} PARENT_SCOPE)
endfunction()

# Not part of the interface: oldest accepted version and the Debian package of a library.
function(_srslam_dependency_facts name out_minimum out_debian_package)
  set(minimum)
  if(name STREQUAL "Eigen3")
    set(minimum 3.3)
    set(debian_package libeigen3-dev)
  elseif(name STREQUAL "OpenCV")
    set(minimum 4.2)
    set(debian_package libopencv-dev)
  elseif(name STREQUAL "Ceres")
    set(minimum 2.1) # ceres::Manifold
    set(debian_package libceres-dev)
  elseif(name STREQUAL "nanoflann")
    set(minimum 1.3.2)
    set(debian_package libnanoflann-dev)
  elseif(name STREQUAL "Threads")
    set(debian_package libc6-dev)
  elseif(name STREQUAL "CLI11")
    set(debian_package libcli11-dev)
  elseif(name STREQUAL "nlohmann_json")
    set(debian_package nlohmann-json3-dev)
  elseif(name STREQUAL "GTest")
    set(debian_package "libgtest-dev libgmock-dev")
  elseif(name STREQUAL "benchmark")
    set(debian_package libbenchmark-dev)
  endif()
  set(${out_minimum} "${minimum}" PARENT_SCOPE)
  set(${out_debian_package} "${debian_package}" PARENT_SCOPE)
endfunction()

# srslam_find_dependency(<specification> <out-message> [GLOBAL])
#
# Looks for a library unless its targets exist already. <out-message> is empty on success, else it
# says what is missing and which Debian package brings it; nothing else is printed and nothing
# fails. No version is passed to find_package(), since a library whose version file accepts one
# major version only would refuse its own successors; the version found is compared here instead.
#
# With GLOBAL the targets found can be used in the whole build, also above the directory of the
# caller. A project that adds srslam as a subdirectory needs that to link a static component.
function(srslam_find_dependency specification out_message)
  cmake_parse_arguments(arg "GLOBAL" "" "" ${ARGN})
  set(${out_message} "" PARENT_SCOPE)
  srslam_dependency_targets("${specification}" targets)
  set(absent)
  foreach(target IN LISTS targets)
    if(NOT TARGET ${target})
      list(APPEND absent ${target})
    endif()
  endforeach()
  if(NOT absent)
    return()
  endif()

  _srslam_split_specification("${specification}" name modules)
  _srslam_dependency_facts("${name}" minimum debian_package)
  set(hint "(Debian package: ${debian_package})")

  if(NOT CMAKE_VERSION VERSION_LESS 3.21)
    get_property(targets_before DIRECTORY PROPERTY IMPORTED_TARGETS)
  endif()
  # Some packages report each of their own dependencies even when asked to be quiet.
  set(CMAKE_MESSAGE_LOG_LEVEL NOTICE)
  if(name STREQUAL "Threads")
    find_package(Threads QUIET)
  elseif(name STREQUAL "OpenCV")
    find_package(OpenCV QUIET NO_MODULE COMPONENTS ${modules})
  else()
    find_package(${name} QUIET NO_MODULE)
  endif()

  if(NOT ${name}_FOUND)
    set(${out_message} "${specification} was not found ${hint}" PARENT_SCOPE)
    return()
  endif()
  if(minimum AND ${name}_VERSION VERSION_LESS minimum)
    set(${out_message}
        "${name} ${${name}_VERSION} in ${${name}_DIR} is older than ${minimum} ${hint}"
        PARENT_SCOPE)
    return()
  endif()
  foreach(target IN LISTS targets)
    if(NOT TARGET ${target})
      set(${out_message}
          "${name} ${${name}_VERSION} in ${${name}_DIR} lacks the target ${target} ${hint}"
          PARENT_SCOPE)
      return()
    endif()
  endforeach()

  if(arg_GLOBAL)
    if(CMAKE_VERSION VERSION_LESS 3.21)
      # Older versions cannot list what a package brought, so only what is linked by name is made
      # global, and every OpenCV module, since OpenCV refuses to be found again half defined.
      set(found_targets ${absent})
      if(name STREQUAL "OpenCV")
        list(APPEND found_targets ${OpenCV_LIB_COMPONENTS})
        list(REMOVE_DUPLICATES found_targets)
      endif()
    else()
      get_property(found_targets DIRECTORY PROPERTY IMPORTED_TARGETS)
      if(targets_before)
        list(REMOVE_ITEM found_targets ${targets_before})
      endif()
    endif()
    foreach(target IN LISTS found_targets)
      if(TARGET ${target})
        set_target_properties(${target} PROPERTIES IMPORTED_GLOBAL TRUE)
      endif()
    endforeach()
  endif()
endfunction()
