# Configures, builds and runs the project SOURCE in the fresh folder BINARY.
#
# With PREFIX the project finds srslam there, and the commands that compile it must not mention
# PROJECT_FOLDER/include. With REFUSED_WITH the configuration must fail and its message must match
# every one of these regular expressions. Every program that the project puts into bin/ is run, with
# ARGUMENTS; at least one must be there, and each must succeed.

cmake_minimum_required(VERSION 3.16...3.25)

file(REMOVE_RECURSE "${BINARY}")
set(prefixes ${PREFIX} ${EXTRA_PREFIXES})
execute_process(
  COMMAND ${CMAKE_COMMAND} -S "${SOURCE}" -B "${BINARY}" -G "${GENERATOR}"
    "-DCMAKE_BUILD_TYPE=${BUILD_TYPE}"
    "-DCMAKE_CXX_FLAGS_DEBUG=-O0" # debug information takes a quarter of the time
    "-DCMAKE_CXX_COMPILER=${CXX_COMPILER}"
    "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}"
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${CXX_COMPILER_LAUNCHER}"
    "-DCMAKE_PREFIX_PATH=${prefixes}"
    -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
    "-DCMAKE_RUNTIME_OUTPUT_DIRECTORY=${BINARY}/bin"
    ${OPTIONS}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)

if(REFUSED_WITH)
  if(result EQUAL 0)
    message(FATAL_ERROR "the configuration should have been refused:\n${output}")
  endif()
  string(REGEX REPLACE "[ \n]+" " " flat_output "${output}")
  foreach(expression IN LISTS REFUSED_WITH)
    if(NOT flat_output MATCHES "${expression}")
      message(FATAL_ERROR "the refusal does not say '${expression}':\n${output}")
    endif()
  endforeach()
  message(STATUS "refused as it should be:\n${output}")
  return()
endif()

if(NOT result EQUAL 0)
  message(FATAL_ERROR "configuration failed:\n${output}")
endif()
if(PREFIX)
  file(READ "${BINARY}/compile_commands.json" commands)
  string(FIND "${commands}" "${PROJECT_FOLDER}/include" position)
  if(NOT position EQUAL -1)
    message(FATAL_ERROR "the consumer is compiled with ${PROJECT_FOLDER}/include:\n${commands}")
  endif()
  file(STRINGS "${BINARY}/CMakeCache.txt" found REGEX "^srslam_DIR:PATH=")
  string(FIND "${found}" "srslam_DIR:PATH=${PREFIX}/" position)
  if(NOT position EQUAL 0)
    message(FATAL_ERROR "srslam was not found in ${PREFIX}: ${found}")
  endif()
endif()
message("${output}")

execute_process(
  COMMAND ${CMAKE_COMMAND} --build "${BINARY}" --config "${BUILD_TYPE}"
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "build failed:\n${output}")
endif()

file(GLOB_RECURSE programs "${BINARY}/bin/*")
if(NOT programs)
  message(FATAL_ERROR "the project built no program")
endif()
foreach(program IN LISTS programs)
  message("${program} ${ARGUMENTS}")
  execute_process(COMMAND "${program}" ${ARGUMENTS}
    WORKING_DIRECTORY "${BINARY}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${program} failed: ${result}")
  endif()
endforeach()
