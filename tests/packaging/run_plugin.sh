#!/usr/bin/env bash
# Builds the plugin of examples/ against an installation and runs its hosts. Then checks what the plugin exports and
# which libraries it needs.
# Usage: run_plugin.sh PREFIX WORK_FOLDER [CMake argument ...]
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
prefix=$1 work=$2
shift 2
rm -rf "$work"
cmake -S "$here/../../examples/plugin" -B "$work" -D CMAKE_PREFIX_PATH="$prefix" -D CMAKE_BUILD_TYPE=Release \
  -D CMAKE_C_FLAGS="-Wall -Wextra -Wpedantic -Werror" "$@"
cmake --build "$work"
ctest --test-dir "$work" --output-on-failure

declared=$(grep -oE '\bsaltus_[a-z_]+\(' "$prefix/include/saltus/c/saltus_c.h" | tr -d '(' | sort -u)
exported=$(nm -D --defined-only "$work/cart.so" | awk '{print $3}' | sort -u)
if [[ $exported != "$declared" ]]; then
  echo "the plugin does not export exactly the functions of saltus_c.h:"
  diff <(echo "$declared") <(echo "$exported") || true
  exit 1
fi
# Libraries of the system, and those of component core (docs/install.md).
known='libc|libm|libstdc\+\+|libgcc_s|ld-linux-[a-z0-9-]+|libfmt|libklu|libbtf|libcholmod|libamd|libcolamd|libcamd|libccolamd|libsuitesparseconfig|libsaltus_[a-z_]+'
needed=$(readelf -d "$work/cart.so" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p')
if grep -vE "^($known)\.so" <<<"$needed"; then
  echo "the plugin needs these libraries, which are not dependencies of component core"
  exit 1
fi
echo "plugin: $(wc -l <<<"$exported") functions exported, needs $(xargs <<<"$needed")"
