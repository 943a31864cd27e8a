#!/bin/sh
# Installs the library from a build, moves what was installed, and builds and runs a project against it.
# Usage: run.sh BUILD CMAKE VERSION
set -eu
build=$1
cmake=$2
version=$3
here=$(cd "$(dirname "$0")" && pwd)
temp=$(mktemp -d)
trap 'rm -rf "$temp"' EXIT

"$cmake" --install "$build" --component library --prefix "$temp/first" >"$temp/log" || { cat "$temp/log"; exit 1; }
mv "$temp/first" "$temp/moved"
find "$temp/moved" -type f | sort
if grep -rq -e "$build" -e "$temp" "$temp/moved" --include='*.cmake' --include='*.h'; then
  echo "a place of this machine is named in what was installed" >&2
  exit 1
fi
"$cmake" -S "$here" -B "$temp/build" -DCMAKE_PREFIX_PATH="$temp/moved" -DVERSION="$version" >"$temp/log" ||
  { cat "$temp/log"; exit 1; }
"$cmake" --build "$temp/build" >"$temp/log" || { cat "$temp/log"; exit 1; }
"$temp/build/example" | tee "$temp/out"
grep -q "^tetfusion $version: 3072 -> 15[0-9][0-9] tetrahedra$" "$temp/out"
"$temp/build/example_c" | grep -qx "tetfusion $version in C: 1 tetrahedron with height"
# Nothing but the library is linked by whoever uses it, and it shows nothing but the header's functions.
if readelf -d "$temp/build/example" | grep -E 'NEEDED.*(fmt|vtk|tbb|hdf5|pugixml)'; then
  exit 1
fi
nm -DC --defined-only "$temp"/moved/lib*/*/libtetfusion.so "$temp"/moved/lib*/libtetfusion.so 2>/dev/null |
  grep ' T ' | grep -v -e 'tetfusion::simplify(tetfusion::Mesh' -e tetfusion::OwnedValues::OwnedValues \
    -e tetfusion::library_version -e " tetfusion_[a-z_]*$" >"$temp/shown" || true
[ ! -s "$temp/shown" ] || { echo "shown besides:"; cat "$temp/shown"; exit 1; }
# Another minor version is another interface.
if "$cmake" -S "$here" -B "$temp/other" -DCMAKE_PREFIX_PATH="$temp/moved" -DVERSION=0.99 >/dev/null 2>&1; then
  echo "version 0.99 was found" >&2
  exit 1
fi
