#!/bin/sh
# The main job from nothing, on a bare Debian 12 too: installs what the build needs (root or sudo), builds the
# command, makes a mesh of about a million tetrahedra, simplifies it, checks the result and says what happened.
# Usage: quickstart.sh [FOLDER]     (default: build/quickstart; the meshes stay there)
set -eu
cd "$(dirname "$0")/.."
folder=${1:-build/quickstart}

sh tests/install_packages.sh build
cmake --preset release
cmake --build --preset release
mkdir -p "$folder"

tetfusion=build/release/tetfusion
echo
echo "== a mesh of about a million tetrahedra"
$tetfusion generate five --tets 1M --jitter 0.5 -o "$folder/mesh.vtu"
$tetfusion info "$folder/mesh.vtu"
echo
echo "== simplified"
$tetfusion simplify "$folder/mesh.vtu" -o "$folder/small.vtu" --reduction 60% --report "$folder/report.json"
echo
echo "== checked"
$tetfusion check "$folder/small.vtu"
echo
echo "== compared"
$tetfusion compare "$folder/mesh.vtu" "$folder/small.vtu"
echo
echo "The meshes are in $folder: open them in ParaView. The report is $folder/report.json."
