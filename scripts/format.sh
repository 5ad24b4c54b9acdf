#!/usr/bin/env bash
# Formats every C++ file of the project, or with --check says which ones are not formatted.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

arguments=(-i)
if [[ ${1:-} == --check ]]; then
  arguments=(--dry-run -Werror)
elif (($# > 0)); then
  echo "usage: scripts/format.sh [--check]" >&2
  exit 2
fi

files=()
while IFS= read -r -d '' file; do
  [[ -f $file ]] && files+=("$file")
done < <(git ls-files -z --cached --others --exclude-standard -- '*.cpp' '*.hpp')
if ((${#files[@]} == 0)); then
  echo "format.sh: no C++ file found" >&2
  exit 1
fi
clang-format "${arguments[@]}" "${files[@]}"
echo "format.sh: ${#files[@]} files"
