#!/bin/sh
# Installs the VTK filter and its Python package from a build, moves what was installed, and uses it from C++ and Python.
# Usage: run_vtk.sh BUILD CMAKE PYTHON PACKAGES TETFUSION DATA VERSION, where PACKAGES is the folder of Python packages below the prefix, and DATA
# has real meshes, or is not there
set -eu
build=$1
cmake=$2
python=$3
packages=$4
tetfusion=$5
data=$6
version=$7
here=$(cd "$(dirname "$0")" && pwd)
temp=$(mktemp -d)
trap 'rm -rf "$temp"' EXIT

for component in library vtk python; do
  "$cmake" --install "$build" --component $component --prefix "$temp/first" >"$temp/log" || { cat "$temp/log"; exit 1; }
done
mv "$temp/first" "$temp/moved"
find "$temp/moved" -type f | sort
"$cmake" -S "$here/vtk" -B "$temp/build" -DCMAKE_PREFIX_PATH="$temp/moved" -DVERSION="$version" >"$temp/log" 2>&1 ||
  { cat "$temp/log"; exit 1; }
"$cmake" --build "$temp/build" >"$temp/log" 2>&1 || { cat "$temp/log"; exit 1; }
"$temp/build/example" | tee "$temp/out"
grep -q "^1296 -> 7[78][0-9] cells$" "$temp/out"
# What the command makes of a real mesh.
if [ -e "$data/bluntfin.vtu" ]; then
  "$tetfusion" simplify "$data/bluntfin.vtu" -o "$temp/expected.vtu" --reduction 50% --quiet
  "$temp/build/example" "$data/bluntfin.vtu" "$temp/expected.vtu"
fi
# Another minor version is another interface.
if "$cmake" -S "$here/vtk" -B "$temp/other" -DCMAKE_PREFIX_PATH="$temp/moved" -DVERSION=0.99 >/dev/null 2>&1; then
  echo "version 0.99 was found" >&2
  exit 1
fi
PYTHONPATH="$temp/moved/$packages" "$python" -c '
import vtktetfusion
print(vtktetfusion.__file__)
assert vtktetfusion.vtkTetFusion().GetTargetReduction() == 0'
