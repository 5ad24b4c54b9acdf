# srslam_set_warnings(<target>)
#
# The project's warnings, for its own sources only: never part of what a target hands on. They are
# errors when SRSLAM_WARNINGS_AS_ERRORS is ON.
function(srslam_set_warnings target)
  if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
    if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
      # Part of -Wconversion to Clang, a warning of its own to GCC.
      target_compile_options(${target} PRIVATE -Wno-sign-conversion)
    endif()
    if(SRSLAM_WARNINGS_AS_ERRORS)
      target_compile_options(${target} PRIVATE -Werror)
    endif()
  elseif(MSVC)
    target_compile_options(${target} PRIVATE /W4)
    if(SRSLAM_WARNINGS_AS_ERRORS)
      target_compile_options(${target} PRIVATE /WX)
    endif()
  endif()
endfunction()
