#!/usr/bin/env bash
# Builds the program and runs it on a folder of RGB-D images in the TUM layout.
#
#   scripts/demo.sh DATASET [argument of `srslam run`]...
#
# The trajectory, its picture and its errors go to build/demo/<name of the folder>.
set -euo pipefail

if (($# < 1)) || [[ $1 == -* ]]; then
  {
    echo "demo.sh: no dataset given. srslam has no sequence of its own yet, so it needs a folder in"
    echo "the TUM RGB-D layout (rgb.txt, depth.txt, rgb/, depth/; groundtruth.txt to see errors):"
    echo "  scripts/demo.sh DATASET [--camera tum_fr1|tum_fr2|tum_fr3|bonn|FILE]"
  } >&2
  exit 2
fi
if [[ ! -d $1 ]]; then
  echo "demo.sh: $1 is not a folder" >&2
  exit 2
fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# In a shell of its own, so that paths among the arguments stay relative to the caller's folder.
(
  # shellcheck source=scripts/common.sh
  source "$root/scripts/common.sh"
  scripts/install_deps.sh
  configure_and_build release srslam_cli
)
output=$root/build/demo/$(basename "$(cd "$1" && pwd)")
mkdir -p "$output"
dataset=$1
shift
exec "$root/build/release/bin/srslam" run --dataset "$dataset" --output "$output" "$@"
