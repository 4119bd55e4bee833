#!/usr/bin/env bash
# Configures, builds and runs the project in outside/ against an installation.
# Usage: run_outside.sh PREFIX WORK_FOLDER COMPONENTS(;-list) [CMake argument ...]
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
prefix=$1 work=$2 components=$3
shift 3
rm -rf "$work"
cmake -S "$here/outside" -B "$work" -D CMAKE_PREFIX_PATH="$prefix" -D COMPONENTS="$components" \
  -D CMAKE_CXX_FLAGS=-DSALTUS_EXPECT_INSTALLED "$@"
cmake --build "$work"
ctest --test-dir "$work" --output-on-failure
