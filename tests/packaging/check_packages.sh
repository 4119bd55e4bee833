#!/usr/bin/env bash
# Builds the Debian packages of a build folder that was configured with SALTUS_PACKAGES=ON and
# CMAKE_INSTALL_PREFIX=/usr, unpacks them into a clean prefix, and uses them: a separate project, the installed
# program without the checkout, and examples/ in Release and Debug.
# Usage: check_packages.sh BUILD_FOLDER WORK_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$(realpath "$1") work=$2
rm -rf "$work"
mkdir -p "$work/debs" "$work/root"
work=$(realpath "$work")
prefix=$work/root/usr

step() { printf 'packages: %s\n' "$*"; }
quietly() { # shows its output only if it fails
  "$@" >"$work/log" 2>&1 || {
    tail -n 60 "$work/log"
    step "failed: $*"
    return 1
  }
}

cd "$work/debs"
quietly cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work/debs"
for package in *.deb; do
  dpkg-deb -x "$package" "$work/root"
done
step "$(ls ./*.deb | wc -l) built: $(ls ./*.deb | sed 's/^..//; s/_.*//' | xargs)"
if command -v lintian >/dev/null; then
  # Without an upload there is no bug to close, and only distributors have an address.
  lintian --allow-root --suppress-tags initial-upload-closes-no-bugs,malformed-contact,bogus-mail-host-in-debian-changelog \
    --fail-on error ./*.deb >"$work/lintian" 2>&1 || {
    cat "$work/lintian"
    exit 1
  }
  step "lintian: no error, $(grep -c '^W:' "$work/lintian" || true) warnings"
fi

components=core
for component in c sundials ipopt app robots dart legged; do
  [[ ! -f $(echo "$prefix"/lib*/*/cmake/saltus/saltus-$component-targets.cmake) ]] || components+=";$component"
done
export LD_LIBRARY_PATH=$(dirname "$(find "$prefix" -name 'libsaltus_dart.so.*' | head -n 1)" 2>/dev/null):${LD_LIBRARY_PATH:-}
quietly "$here/run_outside.sh" "$prefix" "$work/outside" "$components"
step "a project outside, with $components: built and run"

if [[ -x $prefix/bin/saltus ]]; then
  mkdir "$work/elsewhere"
  cd "$work/elsewhere"
  quietly "$prefix/bin/saltus" --help
  quietly "$prefix/bin/saltus" run push_recovery --out run
  [[ -f run/summary.json ]] || { step "the installed program left no summary.json"; exit 1; }
  if /usr/bin/python3 -c 'import matplotlib' 2>/dev/null && ! ls run/*.png >/dev/null 2>&1; then
    cat "$work/log"
    step "the installed program drew no picture: its scripts were not found"
    exit 1
  fi
  step "the installed program: run, with pictures, without the checkout"
fi

examples=$here/../../examples
if [[ -f $examples/CMakeLists.txt ]]; then
  for configuration in Release Debug; do
    folder=$work/examples-$configuration
    quietly cmake -S "$examples" -B "$folder" -D CMAKE_PREFIX_PATH="$prefix" -D CMAKE_BUILD_TYPE=$configuration
    quietly cmake --build "$folder" -j "$(nproc)"
    quietly ctest --test-dir "$folder" --output-on-failure
    step "examples in $configuration: built and run"
  done
fi
