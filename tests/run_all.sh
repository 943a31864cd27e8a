#!/bin/sh
# Builds everything and runs all tests, on a bare Debian 12 too: installs what is missing (needs root or sudo), then
# the release build with warnings as errors, VTK plugin included, then the unit tests once more under
# AddressSanitizer and UndefinedBehaviorSanitizer.
set -eu
cd "$(dirname "$0")/.."

sh tests/install_packages.sh test

cmake --preset ci
cmake --build --preset ci
cmake --preset asan
cmake --build --preset asan
ctest --preset asan --label-exclude "slow|release_only"
ctest --preset ci --label-exclude slow
