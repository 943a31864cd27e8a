#!/bin/sh
# Installs what a build needs on Debian 12 and 13, and on Ubuntu 24.04. Usage: install_packages.sh [build|test|paraview]
#   build: compiler and libraries of the command itself (default)
#   test:  the same, and what the tests use besides: GoogleTest, Python with numpy and h5py, VTK (about 500 MB)
#   paraview: for Debian 12, what the plugin's build and tests use, beside ParaView's own packages: MPI, and what ParaView was built with
# Does nothing where all of it is there already. Needs root, or sudo.
set -eu

packages="g++ cmake ninja-build pkg-config libcli11-dev libfmt-dev nlohmann-json3-dev libpugixml-dev zlib1g-dev
  libdeflate-dev libisal-dev liblz4-dev liblzma-dev libxxhash-dev"
if [ "${1:-build}" = test ]; then
  packages="$packages libgtest-dev libgmock-dev python3 python3-h5py python3-numpy libvtk9-dev python3-vtk9 dpkg-dev file help2man"
fi

if [ "${1:-build}" = paraview ]; then
  packages="$packages dpkg-dev openmpi-bin libopenmpi-dev python3 python3-dev python3-numpy python3-mpi4py libexpat1-dev
    libdouble-conversion-dev libutfcpp-dev libeigen3-dev libavcodec59 libavformat59 libavutil57 libswscale6 libgdal32 libgl2ps1.4
    libglew2.2 libhdf5-openmpi-103-1 libnetcdf19 libtheora0 libogg0 libopengl0 libqt5widgets5 libxcursor1"
fi

missing=""
for package in $packages; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q "ok installed" || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

as_root=""
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || {
    echo "these packages are missing, and installing them needs root or sudo:$missing" >&2
    exit 1
  }
  as_root=sudo
fi
echo "installing:$missing"
export DEBIAN_FRONTEND=noninteractive
$as_root apt-get -qq update
$as_root apt-get -qq install -y --no-install-recommends $missing >/dev/null
