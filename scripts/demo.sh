#!/usr/bin/env bash
# Builds the program, runs it on a sequence and says how large the error is.
#
#   scripts/demo.sh                                        on a rendered room with two walking people
#   scripts/demo.sh DATASET [argument of `srslam run`]...  on a folder of images in the TUM layout
#
# Results go to build/demo/<name of the sequence>: with every module that is built, and beside it,
# in <name>_baseline, with none. The rendered sequence is kept in build/demo/sequences.
set -euo pipefail

dataset=${1:-}
if [[ $dataset == -* ]]; then
  echo "demo.sh: name the dataset first: scripts/demo.sh DATASET [argument of srslam run]..." >&2
  exit 2
fi
if [[ -n $dataset && ! -d $dataset ]]; then
  echo "demo.sh: $dataset is not a folder" >&2
  exit 2
fi
if (($# > 0)); then shift; fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# In a shell of its own, so that paths among the arguments stay relative to the caller's folder.
(
  # shellcheck source=scripts/common.sh
  source "$root/scripts/common.sh"
  scripts/install_deps.sh
  configure_and_build release srslam_cli
)
program=$root/build/release/bin/srslam
demo=$root/build/demo

if [[ -z $dataset ]]; then
  header=$root/include/srslam/synthetic/synthetic_options.hpp
  version=$(sed -n 's/.*kSyntheticWorldVersion = \([0-9]*\);.*/\1/p' "$header")
  name=walking_xyz
  dataset=$demo/sequences/${name}_world$version
  if [[ -f $dataset/rgb.txt ]]; then
    echo "Taking the sequence rendered before: $dataset"
  else
    echo "Rendering $name"
    mkdir -p "$demo/sequences"
    "$program" synth --scenario "$name" --output "$dataset" --overwrite
  fi
else
  name=$(basename "$(cd "$dataset" && pwd)")
fi

# figure <folder> <dotted path>: a value of summary.json, or nothing
figure() {
  python3 - "$1/summary.json" "$2" <<'PYTHON'
import json
import sys

value = json.load(open(sys.argv[1], encoding="utf-8"))
for key in sys.argv[2].split("/"):
    value = value.get(key) if isinstance(value, dict) else None
if value is not None:
    print(f"{value:.4f}" if isinstance(value, float) else value)
PYTHON
}
error_text() {
  local rmse_m
  rmse_m=$(figure "$1" evaluation/trajectory.txt/ate/translation_m/rmse)
  if [[ -n $rmse_m ]]; then
    echo "ATE RMSE $rmse_m m over $(figure "$1" frames/tracked) of $(figure "$1" frames/processed) frames"
  else
    echo "no ground truth to compare with"
  fi
}

output=$demo/$name
mkdir -p "$output"
"$program" run --dataset "$dataset" --output "$output" "$@"
modules=$(figure "$output" modules)
if [[ $modules != none ]]; then
  "$program" run --dataset "$dataset" --output "${output}_baseline" "$@" --modules none
  printf '\nBaseline           %s\n' "$(error_text "${output}_baseline")"
  printf 'Modules %-10s %s\n' "$modules" "$(error_text "$output")"
else
  printf '\nBaseline  %s\n' "$(error_text "$output")"
fi
for page in report.html trajectory.png; do
  if [[ -f $output/$page ]]; then
    echo "Look at   $output/$page"
    break
  fi
done
