#!/usr/bin/env bash
# Creates a project of each kind with an installed program, then builds, runs, draws and tests it.
# Usage: run_new.sh PREFIX WORK_FOLDER [CMake argument ...]
set -euo pipefail
prefix=$1 work=$2
shift 2
rm -rf "$work"
mkdir -p "$work"
cd "$work"
# A program for /usr looks for its shared library there only.
library=$(find "$prefix" -name 'libsaltus_dart.so*' -print -quit)
export LD_LIBRARY_PATH=${library%/*}${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
for kind in trajectory controller switched; do
  "$prefix/bin/saltus" new "my_$kind" --kind "$kind"
  cd "my_$kind"
  ! grep -rn '@[A-Z]*@' . || { echo "a mark was left"; exit 1; }
  cmake -S . -B build -D CMAKE_PREFIX_PATH="$prefix" "$@" >/dev/null
  cmake --build build
  "build/my_$kind"
  ctest --test-dir build --output-on-failure
  for run in plan loop; do
    /usr/bin/env PATH="/usr/bin:$PATH" python3 plot.py "results/$run"
    [[ -s results/$run/trajectory.png ]]
  done
  cd ..
done
# An existing project is not changed: status 2.
status=0
"$prefix/bin/saltus" new my_switched 2>refused.txt || status=$?
[[ $status == 2 ]] && grep -q "'my_switched' exists already; nothing was changed" refused.txt
echo "three new projects: built, run, drawn, tested"
