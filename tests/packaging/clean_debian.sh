#!/usr/bin/env bash
# Runs the steps of docs/install.md in clean file systems of a Debian release: installs Saltus, as packages or
# below a prefix, then configures, builds and runs a separate project and the program. The packages to install
# are read from the tables and lines of that page, so that the page itself is tested.
#
# Usage, as root:
#   clean_debian.sh RELEASE FOLDER [--components core,ipopt | all] [--packages FOLDER_OF_DEBS | --sources]
#                                  [--mirror URL] [--launcher ccache] [--icub-urdf FILE] [--new-user]
# RELEASE is bookworm or trixie. FOLDER receives the file system made by debootstrap, `clean`, and two copies:
# `build`, in which the packages are built unless some are given, and `user`, made anew by every run, without
# the requirements of a build. With --sources the user builds and installs below a prefix instead, with only the
# -dev packages of the components. The given launcher is installed where compilers run and keeps its cache in
# FOLDER. The model of iCub is downloaded as by the program, or taken from the folder of the given URDF. With
# --new-user and all components, new_user.py runs the commands of README, tutorial and `saltus new` instead of the
# projects of tests/packaging and examples. Every step is printed with the seconds since the start and its processor
# time. The default mirror is that of apt on this machine. All components take 6 GB. JOBS compilers run at once, by
# default one per processor. Needs debootstrap.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source_tree=$(realpath "$here/../..")
page=$source_tree/docs/install.md

(($# >= 2)) || { sed -n '2,19s/^# \{0,1\}//p' "$0"; exit 2; }
release=$1
mkdir -p "$2"
folder=$(realpath "$2")
shift 2
components=core packages= sources= launcher= new_user= icub_urdf= jobs=${JOBS:-$(nproc)}
mirror=$(apt-cache policy | sed -nE 's|^ *[0-9]+ (https?://[^ ]+) [a-z-]+/main .*|\1|p' | grep -v security | head -n 1)
while (($# > 0)); do
  case $1 in
    --sources) sources=yes; shift; continue ;;
    --new-user) new_user=yes; shift; continue ;;
    --components | --packages | --mirror | --launcher | --icub-urdf) (($# > 1)) || { echo "$1 needs a value" >&2; exit 2; } ;;
    *) echo "unknown option $1" >&2; exit 2 ;;
  esac
  case $1 in
    --components) components=${2//,/;} ;;
    --packages) packages=$(realpath "$2") ;;
    --mirror) mirror=$2 ;;
    --launcher) launcher=$2 ;;
    --icub-urdf) icub_urdf=$(realpath "$2") ;;
  esac
  shift 2
done
everything="core;c;sundials;ipopt;app;robots;dart;mujoco;legged"
[[ $components != all ]] || components=$everything
((EUID == 0)) || { echo "root is needed to make a file system" >&2; exit 1; }
command -v debootstrap >/dev/null || { echo "debootstrap is missing: apt-get install debootstrap" >&2; exit 1; }

log=$folder/log
began=$SECONDS
processor_seconds() { # of this script and of its child processes
  awk -v hz="$(getconf CLK_TCK)" '{ sub(/.*\) /, ""); printf "%d", ($12 + $13 + $14 + $15) / hz }' "/proc/$$/stat"
}
step() { printf '%s, %d s (%d s of processors): %s\n' "$release" $((SECONDS - began)) "$(processor_seconds)" "$*"; }
quietly() { # shows the end of its output only if it fails
  "$@" >"$log" 2>&1 || {
    local status=$?
    tail -n 60 "$log"
    step "failed ($status): $*"
    exit 1
  }
}

# ---- file systems ---------------------------------------------------------------------------------

mounted=()
unmount() { ((${#mounted[@]} == 0)) || umount --lazy "${mounted[@]}"; }
trap unmount EXIT

# enter ROOT: later commands run `inside` it.
enter() {
  root=$1
  mount -t proc proc "$root/proc"
  mounted+=("$root/proc")
  # Installs only the declared dependencies of packages.
  echo 'APT::Get::Assume-Yes "true"; APT::Install-Recommends "false"; Dpkg::Use-Pty "false";' >"$root/etc/apt/apt.conf.d/90clean"
  echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/fast" # this file system can be made again
  if [[ -n $launcher ]]; then
    mkdir -p "$folder/cache" "$root/var/cache/compiler"
    mount --bind "$folder/cache" "$root/var/cache/compiler"
    mounted+=("$root/var/cache/compiler")
  fi
  quietly inside apt-get update
}
inside() {
  local compiler=()
  # For both languages, and for precompiled headers.
  [[ -z $launcher ]] || compiler=(CMAKE_C_COMPILER_LAUNCHER="$launcher" CMAKE_CXX_COMPILER_LAUNCHER="$launcher"
    CXXFLAGS=-fpch-preprocess CCACHE_DIR=/var/cache/compiler CCACHE_NOHASHDIR=1 CCACHE_COMPILERCHECK=content
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime)
  chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    "${compiler[@]}" "$@"
}
inside_sh() { quietly inside sh -c "set -e; $1"; }
fresh_copy() {
  ! grep -q " $folder/$1/" /proc/mounts || { echo "something is mounted in $folder/$1" >&2; exit 1; }
  rm -rf "${folder:?}/$1"
  cp -a "$folder/clean" "$folder/$1"
}
put_sources() { # copies the files that git tracks into the file system
  rm -rf "$root/src/saltus/"{framework,integrators,robots,problems,tests,benchmarks,examples,docs,python}
  mkdir -p "$root/src/saltus"
  (cd "$source_tree" && git ls-files -z | xargs -0 tar c) | tar x -C "$root/src/saltus" --no-same-owner
}

# ---- contents of the page -------------------------------------------------------------------------

# packages_of COMPONENT: the packages in the table, to build and to use it.
packages_of() { sed -nE "s/^\| $1 \|.*\|([^|]*)\|\$/\1/p" "$page" | grep -oE '[a-z0-9][a-z0-9.+-]*-dev' || true; }
# line_of_page BEGINNING: the first line of a sample with this beginning.
line_of_page() { grep -m 1 -F -e "$1" "$page" | sed 's/ *#.*//'; }
needed=$(for component in ${components//;/ }; do packages_of "$component"; done | sort -u | xargs)

if [[ ! -x $folder/clean/usr/bin/apt-get ]]; then
  step "making a clean file system from $mirror"
  quietly debootstrap --variant=minbase "$release" "$folder/clean.new" "$mirror"
  mv "$folder/clean.new" "$folder/clean"
fi

# ---- 1. install -----------------------------------------------------------------------------------

if [[ -z $packages && -z $sources ]]; then
  [[ -d $folder/build ]] || fresh_copy build
  enter "$folder/build"
  to_build=$(line_of_page "apt-get install g++ cmake ninja-build")
  step "$to_build $needed"
  inside_sh "$to_build $needed $launcher"
  put_sources
  step "building the packages of $components with $(inside g++ --version | head -n 1)"
  choice="-D SALTUS_COMPONENTS='$components'"
  [[ $components != "$everything" ]] || choice=
  inside_sh "cd /src/saltus && cmake --fresh --preset package $choice"
  inside_sh "cd /src/saltus && cmake --build build-package -j $jobs"
  step "built, $(grep -c 'warning:' "$log" || true) warnings"
  cp "$log" "$folder/build.log"
  inside_sh "cd /src/saltus/build-package && rm -f *.deb && cpack"
  packages=$root/src/saltus/build-package
fi

fresh_copy user
enter "$folder/user"
if [[ -n $sources ]]; then
  # Installs to a prefix, with the packages of the requested components only.
  to_build=$(line_of_page "apt-get install g++ cmake make")
  step "$to_build $needed"
  inside_sh "$to_build $needed $launcher"
  put_sources
  for command in "cmake -S . -B build-mine -D SALTUS_COMPONENTS='$components' -D CMAKE_BUILD_TYPE=Release" \
    "cmake --build build-mine -j $jobs" "cmake --install build-mine --prefix /opt/saltus"; do
    step "$command"
    inside_sh "cd /src/saltus && $command"
  done
  # The default configuration finds exactly these components.
  inside_sh "cd /src/saltus && cmake -S . -B build-found"
  step "by default: $(grep -o 'Saltus without [a-z]*' "$log" | sed 's/Saltus //' | xargs)"
  rm -rf "$root/src/saltus/build-mine" "$root/src/saltus/build-found"
  prefix="-D CMAKE_PREFIX_PATH=/opt/saltus"
else
  mkdir -p "$root/src/debs"
  cp "$packages"/*.deb "$root/src/debs/"
  wanted=() # the packages of the library, and the Saltus packages that they need
  for component in ${components//;/ }; do
    name=libsaltus-$component-dev
    [[ $component != core ]] || name=libsaltus-dev
    if compgen -G "$root/src/debs/${name}_*.deb" >/dev/null; then
      wanted+=("./${name}_*.deb")
    else
      step "there is no package $name"
      exit 1
    fi
    [[ $component != dart ]] || wanted+=("./libsaltus-dart0*.deb")
  done
  to_use=$(line_of_page "apt-get install g++ cmake make")
  step "$to_use; apt-get install ${wanted[*]}"
  inside_sh "$to_use $launcher"
  inside_sh "cd /src/debs && apt-get install ${wanted[*]}"
  prefix=
fi

# ---- 2. use ----------------------------------------------------------------------------------------

# The project of the page: its CMakeLists.txt with the available components, and the first problem.
mkdir -p "$root/src/car"
sed -n '/^# CMakeLists.txt$/,/^```$/{/^```$/!p}' "$page" >"$root/src/car/CMakeLists.txt"
[[ $components == *ipopt* ]] || sed -i 's/ core ipopt)/ core)/; s/ saltus::ipopt)/)/' "$root/src/car/CMakeLists.txt"
cp "$source_tree/docs/first_problem.cpp" "$root/src/car/car.cpp"
configure=$(line_of_page "cmake -S . -B build -D CMAKE_BUILD_TYPE=Release")
for command in "$configure $prefix" "cmake --build build" build/car; do
  step "car: $command"
  inside_sh "cd /src/car && $command"
done
step "$(tail -n 1 "$log")"

if [[ -z $new_user ]]; then
  cp -r "$here/outside" "$root/src/outside"
  for command in "cmake -S /src/outside -B /src/work -D COMPONENTS='$components' $prefix" "cmake --build /src/work -j $jobs" \
    "ctest --test-dir /src/work --output-on-failure"; do
    step "outside: $command"
    inside_sh "$command"
  done
  step "$(grep 'tests passed' "$log")"

  if [[ ";$components;" == *";c;"* && $components == *sundials* && $components == *ipopt* ]]; then
    cp -r "$source_tree/examples" "$root/src/examples"
    for command in "cmake -S /src/examples -B /src/examples/build -D CMAKE_BUILD_TYPE=Release $prefix" \
      "cmake --build /src/examples/build -j $jobs" "ctest --test-dir /src/examples/build --output-on-failure"; do
      step "examples: $command"
      inside_sh "$command"
    done
    step "$(grep 'tests passed' "$log")"
  fi
fi

# ---- the program ----------------------------------------------------------------------------------

compgen -G "$root/src/debs/saltus_*.deb" >/dev/null || exit 0
step "apt-get install ./saltus_*.deb ./libsaltus-dart0*.deb"
inside_sh "cd /src/debs && apt-get install ./saltus_*.deb ./libsaltus-dart0*.deb"
inside_sh "saltus list"
step "saltus list: $(wc -l <"$log") lines"
inside_sh "mkdir /src/runs && cd /src/runs && saltus run bryson_denham --out bare && cat bare/summary.json"
step "saltus run bryson_denham, without what is recommended: $(ls "$root/src/runs/bare" | xargs)"
# The recommended packages, for pictures and the download of the model. By default apt installs them, too.
inside_sh "apt-get install \$(dpkg-query -W -f '\${Recommends}' saltus | tr -d ,)"
inside_sh "cd /src/runs && saltus run bryson_denham --out problem"
step "saltus run bryson_denham: $(ls "$root/src/runs/problem" | xargs)"
ls "$root"/src/runs/problem/*.png >/dev/null
inside_sh "cd /src/runs && saltus run push_recovery --out centroidal"
step "saltus run push_recovery: $(ls "$root/src/runs/centroidal" | xargs)"
ls "$root"/src/runs/centroidal/*.png "$root/src/runs/centroidal/summary.json" >/dev/null
environment=
if [[ -n $icub_urdf ]]; then # .../share/iCub/robots/iCubGazeboV2_5/model.urdf, with the meshes next to it
  mkdir -p "$root/src/share"
  cp -r "${icub_urdf%/robots/*}" "$root/src/share/"
  environment=SALTUS_ICUB_URDF=/src/share/iCub/robots/iCubGazeboV2_5/model.urdf
else # over connections that this machine trusts
  cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true
  inside_sh update-ca-certificates
fi
inside_sh "cd /src/runs && $environment saltus run push_recovery --plant dart --out dart"
step "saltus run push_recovery --plant dart: $(ls "$root/src/runs/dart" | xargs); cache: $(ls "$root/root/.cache/saltus" 2>/dev/null | xargs)"
ls "$root/src/runs/dart/report.html" >/dev/null

# ---- commands of the pages ------------------------------------------------------------------------

[[ -n $new_user ]] || exit 0
mkdir -p "$root/src/pages"
(cd "$source_tree" && git ls-files -z README.md docs problems/README.md python tests/packaging | xargs -0 tar c) | tar x -C "$root/src/pages" --no-same-owner
# For pip: the certificates of an installed Debian, and those that this machine trusts.
cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/" 2>/dev/null || true
inside_sh "apt-get install ca-certificates python3-dev && update-ca-certificates" # the package of pip compiles an extension
step "as a new user"
inside env ${environment:-A=} python3 -B /src/pages/tests/packaging/new_user.py /src/pages /src/new_user
