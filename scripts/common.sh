# Sourced by the other scripts: goes to the project's folder and sets up what all builds share.
# shellcheck shell=bash

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

# shellcheck disable=SC2034  # for the script that sources this file
jobs=$(nproc)

# An environment variable rather than an option, so that builds within tests use it too.
if [[ -z ${CMAKE_CXX_COMPILER_LAUNCHER:-} ]] && command -v ccache >/dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
fi

# configure_and_build <preset> [target...]
configure_and_build() {
  local preset=$1
  shift
  cmake --preset "$preset"
  if (($# > 0)); then
    cmake --build --preset "$preset" --parallel "$jobs" --target "$@"
  else
    cmake --build --preset "$preset" --parallel "$jobs"
  fi
}
