#!/usr/bin/env bash
# Builds the lowest libraries as shared libraries and checks that they export symbols of Saltus only.
# Usage: run_shared.sh WORK_FOLDER [CMake argument ...]
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$1
shift
rm -rf "$work"
cmake -S "$here/../.." -B "$work" -D BUILD_SHARED_LIBS=ON -D SALTUS_COMPONENTS=core "$@" >/dev/null
cmake --build "$work" --target saltus_autodiff -j 2
libraries=$(find "$work" -name 'libsaltus_*.so' | sort)
[[ $(wc -l <<<"$libraries") == 2 ]] || { echo "expected two shared libraries"; exit 1; }
for library in $libraries; do
  nm -DC --defined-only "$library" >"$work/symbols"
  [[ -s $work/symbols ]] || { echo "$library exports nothing"; exit 1; }
  ! grep -v 'saltus::' "$work/symbols" || { echo "$library exports symbols of other libraries"; exit 1; }
  echo "$(basename "$library"): $(wc -l <"$work/symbols") symbols"
done
