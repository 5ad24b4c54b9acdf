#!/usr/bin/env bash
# Runs the program on damaged copies of a dataset and checks that it never crashes, never hangs and
# always says why it gives up.
#
#   run_corruptions.sh PROGRAM DATASET N [further arguments of `PROGRAM run`]
#
#   run_corruptions.sh build/release/bin/srslam ~/data/fr1_xyz 100 --camera tum_fr1 --max-frames 60
#
# A run passes when it ends in time without a signal, and, if its exit code is not 0, with a line
# `error: <reason>` on stderr; if it is 0, with a trajectory that holds numbers only. Damaged copies of the runs that
# fail are kept. The exit code is 0 when every run passes.
#
# Environment: TIMEOUT_S seconds a run (default 120), FIRST_SEED (default 1), CXX compiler for the
# tool that makes the copies (default c++), CORRUPT_DATASET that tool, already built.
set -euo pipefail

if [ "$#" -lt 3 ]; then
  sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0" >&2
  exit 2
fi
program=$1
dataset=$2
count=$3
shift 3
timeout_s=${TIMEOUT_S:-120}
first_seed=${FIRST_SEED:-1}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

if [ ! -x "$program" ]; then
  echo "run_corruptions.sh: '$program' is no program" >&2
  exit 2
fi
if [ ! -d "$dataset" ]; then
  echo "run_corruptions.sh: '$dataset' is no folder" >&2
  exit 2
fi
if ! [[ "$count" =~ ^[1-9][0-9]*$ ]]; then
  echo "run_corruptions.sh: N must be a positive number, got '$count'" >&2
  exit 2
fi

work=$(mktemp -d)
failed=0
cleanup() {
  if [ "$failed" -eq 0 ]; then rm -rf "$work"; else echo "kept: $work"; fi
}
trap cleanup EXIT

corrupt=${CORRUPT_DATASET:-$work/corrupt_dataset}
if [ -z "${CORRUPT_DATASET:-}" ]; then
  "${CXX:-c++}" -std=c++17 -O1 -o "$corrupt" "$here/corrupt_dataset.cpp"
fi

refused=0
accepted=0
for ((seed = first_seed; seed < first_seed + count; ++seed)); do
  copy=$work/copy$seed
  output=$work/output$seed
  log=$work/log$seed
  damages=$("$corrupt" "$dataset" "$copy" "$seed")
  code=0
  timeout --kill-after=10 "$timeout_s" "$program" run --dataset "$copy" --output "$output" "$@" \
    >"$log.out" 2>"$log.err" </dev/null || code=$?
  problem=
  if [ "$code" -eq 124 ]; then
    problem="did not end within $timeout_s s"
  elif [ "$code" -gt 124 ]; then
    problem="ended by a signal or could not be run (exit code $code)"
  elif grep -qE 'Sanitizer|runtime error:' "$log.err"; then
    problem="a sanitizer reported an error"
  elif [ "$code" -ne 0 ]; then
    if ! grep -qi 'error: *[^[:space:]]' "$log.err"; then
      problem="exit code $code without a reason"
    fi
    refused=$((refused + 1))
  else
    if [ ! -f "$output/trajectory.txt" ]; then
      problem="exit code 0 without trajectory.txt"
    elif grep -v '^#' "$output/trajectory.txt" | grep -qiE 'nan|inf'; then
      problem="trajectory.txt holds NaN or infinity"
    fi
    accepted=$((accepted + 1))
  fi
  if [ -n "$problem" ]; then
    failed=$((failed + 1))
    printf 'seed %d: %s\n' "$seed" "$problem"
    printf '  %s\n' "${damages//$'\n'/$'\n'  }"
    tail -n 5 "$log.err" | sed 's/^/  stderr: /'
  else
    rm -rf "$copy" "$output" "$log.out" "$log.err"
  fi
done
echo "$count damaged datasets: $accepted run to the end, $refused refused with a reason, $failed failed"
[ "$failed" -eq 0 ]
