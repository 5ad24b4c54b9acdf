#!/usr/bin/env bash
# Builds the program and the benchmarks, optimised:
#   build/release/bin/srslam
#   build/release/bin/bench_<component>
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

scripts/install_deps.sh
configure_and_build release srslam_programs
