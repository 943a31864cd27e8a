#!/bin/sh
# Builds the plugin against ParaView 5.11 and tests it in pvbatch, on a bare Debian 12 too. Usage: run_paraview.sh [PREFIX]
# Debian's python3-paraview and python3-vtk9 exclude each other. So ParaView's three packages are not installed but unpacked
# below PREFIX (default: build/paraview-5.11, 670 MB), and what they need besides is installed (root or sudo), where it is missing. Where
# paraview-dev is installed, that is taken. Test programs of the plugin have the label paraview; a tree with the plugin has no other tests.
set -eu
cd "$(dirname "$0")/../.."
prefix=$(mkdir -p "${1:-build/paraview-5.11}" && cd "${1:-build/paraview-5.11}" && pwd)

sh tests/install_packages.sh paraview  # dpkg-architecture, too
config=lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)/cmake/paraview-5.11
if [ -e "/usr/$config/paraview-config.cmake" ]; then
  root=/usr
else
  root=$prefix/usr
  if [ ! -e "$root/$config/paraview-config.cmake" ]; then
    mkdir -p "$prefix/packages"
    (cd "$prefix/packages" && apt-get -qq download paraview paraview-dev python3-paraview)
    for package in "$prefix"/packages/*.deb; do dpkg -x "$package" "$prefix"; done
    rm -r "$prefix/packages"
  fi
fi
cmake --preset paraview -DParaView_DIR="$root/$config"
cmake --build --preset paraview
ctest --preset paraview --label-regex paraview
