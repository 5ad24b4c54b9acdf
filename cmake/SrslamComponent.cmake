# Components: what a user names in find_package(srslam COMPONENTS ...) and links as srslam::<name>.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(SRSLAM_CMAKE_INSTALL_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/srslam)

# Everything below is remembered in global properties, because interface libraries could not carry
# arbitrary properties before CMake 3.19:
#   SRSLAM_COMPONENTS          components of this build, dependencies first
#   SRSLAM_ABSENT_COMPONENTS   components that an option left out
#   SRSLAM_<name>_{CLOSURE,PACKAGES,HEADERS,SOURCES,ALL_PACKAGES,OPTION}
function(_srslam_get out_variable property)
  get_property(value GLOBAL PROPERTY SRSLAM_${property})
  set(${out_variable} "${value}" PARENT_SCOPE)
endfunction()

# srslam_require(<specification> FOR <who> OPTION <option>)
#
# Stops the configuration with a named error when a library is absent.
function(srslam_require specification)
  cmake_parse_arguments(arg "" "FOR;OPTION" "" ${ARGN})
  srslam_find_dependency("${specification}" problem GLOBAL)
  if(problem)
    set(way_out)
    if(arg_OPTION)
      set(way_out ", or configure with -D${arg_OPTION}=OFF")
    endif()
    message(FATAL_ERROR "srslam: a library for ${arg_FOR} is absent: ${problem}. "
                        "Install it${way_out}.")
  endif()
endfunction()

# srslam_component(<name>
#                  [OPTION <option>]              # the component is left out when this is OFF
#                  [HEADERS <file>...]            # public, relative to include/
#                  [SOURCES <file>...]            # with sources it is compiled, else header-only
#                  [DEPENDS <component>...]       # whose headers its own headers include
#                  [PACKAGES <spec>...]           # libraries that its headers include
#                  [PRIVATE_PACKAGES <spec>...])  # libraries that only its sources include
#
# Adds the target srslam_<name> with the alias srslam::<name>, installs its headers and its own
# export set and makes it known to the package configuration. The one component whose name is that
# of the project, the set of all that need Eigen alone, becomes the target srslam.
function(srslam_component name)
  cmake_parse_arguments(arg "" "OPTION" "HEADERS;SOURCES;DEPENDS;PACKAGES;PRIVATE_PACKAGES" ${ARGN})
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "srslam_component(${name}): unknown argument ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(arg_PRIVATE_PACKAGES AND NOT arg_SOURCES)
    message(FATAL_ERROR "srslam_component(${name}): PRIVATE_PACKAGES without SOURCES")
  endif()
  set_property(GLOBAL PROPERTY SRSLAM_${name}_OPTION "${arg_OPTION}")
  if(arg_OPTION AND NOT ${arg_OPTION})
    set_property(GLOBAL APPEND PROPERTY SRSLAM_ABSENT_COMPONENTS ${name})
    return()
  endif()

  set(closure)
  foreach(dependency IN LISTS arg_DEPENDS)
    if(NOT TARGET srslam::${dependency})
      _srslam_get(dependency_option ${dependency}_OPTION)
      message(FATAL_ERROR "srslam: component ${name} needs component ${dependency}; "
                          "configure with -D${dependency_option}=ON or -D${arg_OPTION}=OFF.")
    endif()
    _srslam_get(dependency_closure ${dependency}_CLOSURE)
    list(APPEND closure ${dependency_closure})
  endforeach()
  list(APPEND closure ${name})
  list(REMOVE_DUPLICATES closure)
  foreach(specification IN LISTS arg_PACKAGES arg_PRIVATE_PACKAGES)
    srslam_require("${specification}" FOR "component ${name}" OPTION "${arg_OPTION}")
  endforeach()

  if(name STREQUAL PROJECT_NAME)
    set(target ${name})
  else()
    set(target srslam_${name})
  endif()
  set(installed_packages ${arg_PACKAGES})
  if(arg_SOURCES)
    set(visibility PUBLIC)
    add_library(${target} ${arg_SOURCES})
    set_target_properties(${target} PROPERTIES
      CXX_EXTENSIONS OFF
      VERSION ${PROJECT_VERSION}
      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
    if(NOT DEFINED CMAKE_POSITION_INDEPENDENT_CODE)
      # A static library must be able to become part of a user's shared one.
      set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    endif()
    target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
    srslam_set_warnings(${target})
    foreach(specification IN LISTS arg_PRIVATE_PACKAGES)
      srslam_dependency_targets("${specification}" package_targets)
      target_link_libraries(${target} PRIVATE ${package_targets})
    endforeach()
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND installed_packages ${arg_PRIVATE_PACKAGES})
    endif()
  else()
    set(visibility INTERFACE)
    add_library(${target} INTERFACE)
  endif()
  add_library(srslam::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${visibility} cxx_std_17)
  target_include_directories(${target} ${visibility}
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>"
    "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  foreach(dependency IN LISTS arg_DEPENDS)
    target_link_libraries(${target} ${visibility} srslam::${dependency})
  endforeach()
  foreach(specification IN LISTS arg_PACKAGES)
    srslam_dependency_targets("${specification}" package_targets)
    target_link_libraries(${target} ${visibility} ${package_targets})
  endforeach()

  set(all_packages ${arg_PACKAGES} ${arg_PRIVATE_PACKAGES})
  set(sources)
  foreach(source IN LISTS arg_SOURCES)
    list(APPEND sources "${CMAKE_CURRENT_SOURCE_DIR}/${source}")
  endforeach()
  set_property(GLOBAL APPEND PROPERTY SRSLAM_COMPONENTS ${name})
  set_property(GLOBAL PROPERTY SRSLAM_${name}_CLOSURE ${closure})
  set_property(GLOBAL PROPERTY SRSLAM_${name}_HEADERS ${arg_HEADERS})
  set_property(GLOBAL PROPERTY SRSLAM_${name}_SOURCES ${sources})
  set_property(GLOBAL PROPERTY SRSLAM_${name}_ALL_PACKAGES ${all_packages})
  set_property(GLOBAL PROPERTY SRSLAM_${name}_PACKAGES ${installed_packages})

  if(SRSLAM_INSTALL)
    install(TARGETS ${target} EXPORT srslam-${name}-targets
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
      LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
      RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
    install(EXPORT srslam-${name}-targets
      NAMESPACE srslam::
      DESTINATION ${SRSLAM_CMAKE_INSTALL_DIR})
    foreach(header IN LISTS arg_HEADERS)
      get_filename_component(folder ${header} DIRECTORY)
      install(FILES ${PROJECT_SOURCE_DIR}/include/${header}
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
    endforeach()
  endif()
endfunction()

# srslam_install_package()
#
# Writes and installs srslamConfig.cmake and its version file; called once, after all components.
function(srslam_install_package)
  _srslam_get(SRSLAM_COMPONENTS COMPONENTS)
  _srslam_get(SRSLAM_ABSENT_COMPONENTS ABSENT_COMPONENTS)
  set(SRSLAM_COMPONENT_TABLE)
  set(architecture ARCH_INDEPENDENT)
  foreach(name IN LISTS SRSLAM_COMPONENTS)
    _srslam_get(closure ${name}_CLOSURE)
    _srslam_get(packages ${name}_PACKAGES)
    _srslam_get(sources ${name}_SOURCES)
    string(APPEND SRSLAM_COMPONENT_TABLE
      "set(_srslam_closure_${name} \"${closure}\")\n"
      "set(_srslam_packages_${name} \"${packages}\")\n")
    if(sources)
      set(architecture)
    endif()
  endforeach()
  configure_package_config_file(
    ${PROJECT_SOURCE_DIR}/cmake/srslamConfig.cmake.in
    ${PROJECT_BINARY_DIR}/cmake/srslamConfig.cmake
    INSTALL_DESTINATION ${SRSLAM_CMAKE_INSTALL_DIR}
    NO_SET_AND_CHECK_MACRO
    NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  # Before 1.0 every minor version may break its users, so none stands in for another.
  write_basic_package_version_file(
    ${PROJECT_BINARY_DIR}/cmake/srslamConfigVersion.cmake
    COMPATIBILITY SameMinorVersion ${architecture})
  install(FILES
    ${PROJECT_BINARY_DIR}/cmake/srslamConfig.cmake
    ${PROJECT_BINARY_DIR}/cmake/srslamConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/SrslamDependencies.cmake
    DESTINATION ${SRSLAM_CMAKE_INSTALL_DIR})
  install(FILES ${PROJECT_BINARY_DIR}/include/srslam/version.hpp
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/srslam)
endfunction()

# srslam_program(<target> <output-name>)
#
# A program or benchmark that users start: lands in bin/ of the build, without language extensions
# and under the project's warnings.
function(srslam_program target output_name)
  set_target_properties(${target} PROPERTIES
    OUTPUT_NAME ${output_name}
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin
    CXX_EXTENSIONS OFF)
  srslam_set_warnings(${target})
  add_dependencies(srslam_programs ${target})
endfunction()
