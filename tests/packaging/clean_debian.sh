#!/usr/bin/env bash
# In a clean file system of a Debian release: builds the packages there (or takes given ones), installs
# them with apt, and configures, builds and runs a project outside, in the order in which docs say.
#
# Usage, as root:
#   clean_debian.sh RELEASE FOLDER [--components core,ipopt] [--packages FOLDER_OF_DEBS] [--mirror URL]
#                                  [--launcher COMMAND]
# RELEASE is bookworm or trixie, FOLDER becomes the file system (about 1.5 GB, kept: a second run is
# faster). The mirror is the one of this machine's apt if none is named. Needs debootstrap.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source_tree=$(realpath "$here/../..")

(($# >= 2)) || { sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 2; }
release=$1 root=$2
shift 2
components=core packages= launcher=
mirror=$(apt-cache policy | sed -nE 's|^ *[0-9]+ (https?://[^ ]+) [a-z-]+/main .*|\1|p' | grep -v security | head -n 1)
while (($# > 0)); do
  case $1 in
    --components) components=${2//,/;} ;;
    --packages) packages=$(realpath "$2") ;;
    --mirror) mirror=$2 ;;
    --launcher) launcher=$2 ;;
    *) echo "unknown option $1" >&2; exit 2 ;;
  esac
  shift 2
done
((EUID == 0)) || { echo "root is needed to make a file system" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "debootstrap is missing: apt-get install debootstrap" >&2; exit 1; }

step() { printf '%s: %s\n' "$release" "$*"; }
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }

if [[ ! -x $root/usr/bin/apt-get ]]; then
  step "making a clean file system from $mirror"
  debootstrap --variant=minbase "$release" "$root" "$mirror" >"$root.log" 2>&1 || { tail -n 20 "$root.log"; exit 1; }
fi
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT
inside apt-get update -qq

if [[ -z $packages ]]; then
  # What the components need to be built; that users need less is what the packages say.
  needed=(g++ cmake ninja-build pkg-config dpkg-dev file libeigen3-dev libfmt-dev libsuitesparse-dev)
  for component in ${components//;/ }; do
    case $component in
      sundials) needed+=(libsundials-dev) ;;
      ipopt) needed+=(coinor-libipopt-dev) ;;
      app) needed+=(nlohmann-json3-dev libyaml-cpp-dev) ;;
      robots) needed+=(nlohmann-json3-dev libyaml-cpp-dev liburdfdom-dev libconsole-bridge-dev) ;;
      dart) needed+=(libdart-collision-bullet-dev libdart-collision-ode-dev libdart-external-ikfast-dev) ;;
    esac
  done
  step "installing what the build needs: ${needed[*]}"
  inside apt-get install -y -qq --no-install-recommends "${needed[@]}" >"$root.log" 2>&1 || { tail "$root.log"; exit 1; }
  step "building the packages of $components with $(inside g++ --version | head -n 1)"
  mkdir -p "$root/src/saltus"
  (cd "$source_tree" && git ls-files -z | xargs -0 tar c) | tar x -C "$root/src/saltus"
  inside sh -c "cd /src/saltus &&
    cmake --preset package -D SALTUS_COMPONENTS='$components' -D SALTUS_BUILD_PROGRAM=OFF -D SALTUS_BUILD_BENCHMARKS=OFF \
      ${launcher:+-D CMAKE_CXX_COMPILER_LAUNCHER=$launcher} &&
    cmake --build build-package && rm -rf /src/debs && cpack -G DEB --config build-package/CPackConfig.cmake -B /src/debs" \
    >"$root.log" 2>&1 || { tail -n 40 "$root.log"; exit 1; }
else
  mkdir -p "$root/src/debs"
  cp "$packages"/*.deb "$root/src/debs/"
fi

# As docs say: install the packages, configure, build, run.
wanted=()
for component in ${components//;/ }; do
  name=libsaltus-$component-dev
  [[ $component != core ]] || name=libsaltus-dev
  wanted+=("/src/debs/$name"_*.deb)
done
step "installing ${wanted[*]##*/}"
inside sh -c "apt-get install -y -qq --no-install-recommends g++ cmake make $(printf '%s ' "${wanted[@]}")" >"$root.log" 2>&1 ||
  { tail "$root.log"; exit 1; }
rm -rf "$root/src/outside" "$root/src/work"
cp -r "$here/outside" "$root/src/outside"
for command in "cmake -S /src/outside -B /src/work -D COMPONENTS='$components'" "cmake --build /src/work" \
  "ctest --test-dir /src/work --output-on-failure"; do
  step "$command"
  inside sh -c "$command" >"$root.log" 2>&1 || { tail -n 40 "$root.log"; exit 1; }
done
step "$(grep 'tests passed' "$root.log")"
