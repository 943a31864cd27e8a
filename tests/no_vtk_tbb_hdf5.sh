#!/bin/sh
# Fails if the command, or the library, that is given as the first argument links VTK, TBB or HDF5.
set -eu
if [ $# -ne 1 ] || [ ! -x "$1" ]; then
  echo "usage: $0 COMMAND (an executable file)" >&2
  exit 2
fi
libraries=$(ldd "$1")
# A listing without the C++ library would mean that the test looks at the wrong thing.
case $libraries in
  *libstdc++*) ;;
  *) echo "ldd shows no C++ library for $1:"; echo "$libraries"; exit 1 ;;
esac
if found=$(echo "$libraries" | grep -iE 'vtk|tbb|hdf5'); then
  echo "$1 must not link:"
  echo "$found"
  exit 1
fi
echo "$1 links neither VTK nor TBB nor HDF5"
