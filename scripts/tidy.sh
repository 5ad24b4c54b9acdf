#!/usr/bin/env bash
# Runs clang-tidy.
#
#   scripts/tidy.sh            on what changed since a base (below), committed or not
#   scripts/tidy.sh --all      on every translation unit
#   scripts/tidy.sh FILE...    on these
#
# The base is the commit in SRSLAM_TIDY_BASE; else where this branch left the branch it is to be
# merged into (origin/HEAD, origin/main or main); else, on that branch itself, the commit in
# .ci/tidy_base, up to which everything has been checked; without any of them, everything is checked.
# A changed header is checked through one translation unit that includes it. How each source is
# compiled comes from build/tidy: build/release without the sources joined, configured but not built.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

build_folder=build/tidy
database=$build_folder/compile_commands.json

find_base() {
  local branch base head
  head=$(git rev-parse HEAD)
  if [[ -n ${SRSLAM_TIDY_BASE:-} ]]; then
    git rev-parse --verify --quiet "$SRSLAM_TIDY_BASE^{commit}" || {
      echo "tidy.sh: SRSLAM_TIDY_BASE=$SRSLAM_TIDY_BASE is no commit" >&2
      return 1
    }
    return
  fi
  for branch in origin/HEAD origin/main main; do
    base=$(git merge-base HEAD "$branch" 2>/dev/null || true)
    if [[ -n $base && $base != "$head" ]]; then
      echo "$base"
      return
    fi
  done
  base=$(cat .ci/tidy_base 2>/dev/null || true)
  if [[ -n $base ]] && git merge-base --is-ancestor "$base" HEAD 2>/dev/null; then
    echo "$base"
  fi
}

base=
changed=()
if (($# > 0)) && [[ $1 != --all ]]; then
  changed=("$@")
  echo "tidy.sh: checking what was named"
else
  if (($# == 0)); then
    base=$(find_base)
  fi
  if [[ -n $base ]] && ! git diff --quiet "$base" -- .clang-tidy; then
    echo "tidy.sh: .clang-tidy changed since ${base:0:12}"
    base=
  fi
  if [[ -n $base ]]; then
    echo "tidy.sh: checking what changed since ${base:0:12} ($(git log -1 --format=%s "$base"))"
    mapfile -t changed < <(
      {
        git diff --name-only --diff-filter=d "$base" -- '*.cpp' '*.hpp'
        git ls-files --others --exclude-standard -- '*.cpp' '*.hpp'
      } | sort -u
    )
  else
    echo "tidy.sh: checking every translation unit"
    mapfile -t changed < <(git ls-files --cached --others --exclude-standard -- '*.cpp' '*.hpp')
  fi
fi

configure() {
  cmake --preset release -B "$build_folder" -DCMAKE_UNITY_BUILD=OFF &&
    cmake --build "$build_folder" --target abi_layout_entries
}
if ! output=$(configure 2>&1); then
  printf '%s\n' "$output" "tidy.sh: build/tidy cannot be configured" >&2
  exit 1
fi
python3 scripts/tidy_units.py "$database" "${changed[@]}" >"$build_folder/tidy_units.txt"
num_units=$(wc -l <"$build_folder/tidy_units.txt")
echo "tidy.sh: $num_units translation units"
if ((num_units == 0)); then
  exit 0
fi
# xargs goes on after a finding and fails at the end.
tr '\n' '\0' <"$build_folder/tidy_units.txt" |
  xargs -0 --max-args=1 --max-procs="$jobs" clang-tidy -p "$build_folder" --quiet
echo "tidy.sh: clean"
