#!/usr/bin/env bash
# Builds everything and runs all tests. Arguments are passed on to ctest (`-R core` for a part).
#
# Tests on real images take their folder from SRSLAM_DATA_DIR and skip without it. When it is not
# set, a folder named shared/data beside the checkout is used if there is one.
# PRESET=dev|asan-ubsan|tsan tests another build than the optimised one.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

preset=${PRESET:-release}
if [[ -z ${SRSLAM_DATA_DIR:-} && -d ../shared/data ]]; then
  SRSLAM_DATA_DIR=$(cd ../shared/data && pwd)
  export SRSLAM_DATA_DIR
fi

scripts/install_deps.sh
configure_and_build "$preset"

report=$PWD/build/$preset/test_report.xml
rm -f "$report"
ctest_status=0
ctest --preset "$preset" --parallel "$jobs" --output-junit "$report" "$@" || ctest_status=$?
python3 scripts/test_summary.py "$report" "$ctest_status"
