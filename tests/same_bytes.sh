#!/bin/sh
# Two builds of the command must make the same bytes: optimisation, assertions and sanitizers change nothing.
# Usage: same_bytes.sh TETFUSION_A TETFUSION_B
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for build in a b; do
  command=$1
  shift
  "$command" generate bcc --tets 300k --jitter 0.7 --grading 5 --shuffle -o "$folder/mesh_$build.vtu" --quiet
  "$command" simplify "$folder/mesh_$build.vtu" -o "$folder/small_$build.vtu" --chunk-tets 50k --quiet
  "$command" simplify "$folder/mesh_$build.vtu" -o "$folder/moved_$build.vtu" --chunk-tets 50k --reduction 80% --boundary 0.5% --quiet
done
cmp "$folder/mesh_a.vtu" "$folder/mesh_b.vtu"
cmp "$folder/small_a.vtu" "$folder/small_b.vtu"
cmp "$folder/moved_a.vtu" "$folder/moved_b.vtu"
echo "the same bytes: $(cksum < "$folder/small_a.vtu")"
