#!/bin/sh
# Builds everything and runs all tests, on a bare Debian 12 too: installs what is missing (needs root or sudo), then
# - the tests under AddressSanitizer and UndefinedBehaviorSanitizer,
# - the parallel part under ThreadSanitizer,
# - all tests of the release build, with warnings as errors and the VTK plugin.
set -eu
cd "$(dirname "$0")/.."

sh tests/install_packages.sh test

for preset in asan tsan ci; do cmake --preset "$preset"; done
cmake --build --preset asan
cmake --build --preset tsan --target test_base test_partition test_driver test_io test_library
cmake --build --preset ci
ctest --preset asan --label-exclude "slow|release_only"
# Without long ones whose threads do what those of others do: a run stops in the same way whatever it fuses.
ctest --preset tsan --label-exclude "slow|release_only" --exclude-regex "StoppedRun.EndsInTheSameBytes.*(Goal|Fuses|Points|Moves)|LevelsThatAreThere|StoppedWayBack|Estimate|DamagedScratch|RealMeshes" --tests-regex "RunTasks|InOrder|Rounds|Chunk|Cut|OutOfCore|StoppedRun|PieceStore|Scratch|Memory|MeshStream|Schedules|Library"
sh tests/same_bytes.sh build/release/tetfusion build/asan/tetfusion
ctest --preset ci --label-exclude slow
# What is not installed, or not there: ctest names whole programs that were skipped, these are parts of the others.
grep -h "^skipped: " build/release/Testing/Temporary/LastTest.log || true
