# What a project that takes srslam in as a part of its own must not notice.

macro(remember_before_srslam)
  get_cmake_property(before_cache CACHE_VARIABLES)
  set(before_flags "${CMAKE_CXX_FLAGS}|${CMAKE_CXX_STANDARD}|${CMAKE_BUILD_TYPE}")
  set(before_flags "${before_flags}|${BUILD_TESTING}|${BUILD_SHARED_LIBS}")
endmacro()

macro(check_after_srslam)
  set(after_flags "${CMAKE_CXX_FLAGS}|${CMAKE_CXX_STANDARD}|${CMAKE_BUILD_TYPE}")
  set(after_flags "${after_flags}|${BUILD_TESTING}|${BUILD_SHARED_LIBS}")
  if(NOT after_flags STREQUAL before_flags)
    message(FATAL_ERROR "srslam changed the project's settings: ${before_flags} -> ${after_flags}")
  endif()

  # New cache variables: its own, and those that CMake and the packages found write themselves.
  get_cmake_property(after_cache CACHE_VARIABLES)
  list(REMOVE_ITEM after_cache ${before_cache})
  list(FILTER after_cache EXCLUDE REGEX
    "^(SRSLAM_|srslam_|FETCHCONTENT_|FIND_PACKAGE_MESSAGE_DETAILS_|CMAKE_PROJECT_VERSION|CMAKE_HAVE_|CMAKE_INSTALL_|_GNUInstallDirs|Eigen3_DIR$|OpenCV_DIR$)")
  if(after_cache)
    message(FATAL_ERROR "srslam left cache variables behind: ${after_cache}")
  endif()

  foreach(target srslam_cli srslam_cli_parts bench_core abi_layout_test)
    if(TARGET ${target})
      message(FATAL_ERROR "srslam defined ${target} without being asked")
    endif()
  endforeach()
  if(SRSLAM_INSTALL OR SRSLAM_WARNINGS_AS_ERRORS OR SRSLAM_BUILD_TESTS)
    message(FATAL_ERROR "options that should be OFF in a subproject are ON")
  endif()
endmacro()
