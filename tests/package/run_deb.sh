#!/bin/sh
# Makes the Debian packages of a build, unpacks the one of the command, and uses what is in it. Usage: run_deb.sh BUILD
set -eu
build=$1
command -v dpkg-shlibdeps >/dev/null || { echo "skipped: no dpkg-dev"; exit 0; }
temp=$(mktemp -d)
trap 'rm -rf "$temp"' EXIT
cd "$build"
cpack -G DEB -B "$temp/packages" >"$temp/log" 2>&1 || { cat "$temp/log"; exit 1; }
package=$(ls "$temp"/packages/tetfusion_*.deb)
dpkg-deb -f "$package" Depends | tee "$temp/depends"
if grep -q vtk "$temp/depends"; then
  echo "the command's package needs VTK" >&2
  exit 1
fi
dpkg-deb -x "$package" "$temp/root"
usr="$temp/root/usr"

for document in copyright README.md CHANGELOG.md src/cli/MANUAL.md src/cli/FORMATS.md src/cli/REPORTS.md; do
  test -s "$usr/share/doc/tetfusion/$document"
done

PATH="$usr/bin:$PATH"
tetfusion generate five --tets 20k --jitter 0.3 -o "$temp/in.vtu" --quiet
tetfusion simplify "$temp/in.vtu" -o "$temp/out.vtu" --reduction 50% --quiet
tetfusion check "$temp/out.vtu" --quiet

cat >"$temp/main.cpp" <<'SOURCE'
#include <tetfusion.h>

#include <cstdio>
int main() { std::puts(tetfusion::library_version()); }
SOURCE
export PKG_CONFIG_PATH="$usr/lib/pkgconfig"
c++ -std=c++20 "$temp/main.cpp" $(pkg-config --cflags --libs tetfusion) -o "$temp/main"
LD_LIBRARY_PATH="$usr/lib" "$temp/main" | grep -qx "$(pkg-config --modversion tetfusion)"

# For any Python that has NumPy.
if python3 -c 'import numpy' 2>/dev/null; then
  PYTHONPATH="$usr/lib/python3/dist-packages" python3 -c 'import tetfusion; print(tetfusion.__version__)' |
    grep -qx "$(pkg-config --modversion tetfusion)"
fi

# Every command has a page, and what is typed is completed.
for name in $(tetfusion --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
  if command -v help2man >/dev/null; then test -s "$usr/share/man/man1/tetfusion-$name.1"; fi
  echo "$name" >>"$temp/commands"
done
if command -v help2man >/dev/null; then grep -q "tetfusion-check .*- find out whether" "$usr/share/man/man1/tetfusion-check.1"; fi
complete() {
  bash -c 'source "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _tetfusion; printf "%s\n" "${COMPREPLY[@]}"' \
    "$usr/share/bash-completion/completions/tetfusion" "$@"
}
complete tetfusion "" | grep -v '^--' | cmp - "$temp/commands"
complete tetfusion simp | grep -qx simplify
complete tetfusion simplify --red | grep -qx -- --reduction
complete tetfusion simplify --report x --verb | grep -qx -- --verbose
complete tetfusion generate k | grep -qx kuhn
test -z "$(complete tetfusion generate kuhn "")"
complete tetfusion simplify --progress a | tr '\n' ' ' | grep -qx 'auto always '
