#!/usr/bin/env bash
# Installs the library into an empty folder, builds the examples against it as a stranger would, and runs them.
#   install_test.sh BUILD_DIR SOURCE_DIR CXX_COMPILER
set -euo pipefail
build=$1 source=$2 compiler=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log" || { cat "$work/install.log"; exit 1; }
cmake -G Ninja -S "$source/examples" -B "$work/examples" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_CXX_COMPILER="$compiler" >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/examples" -j2

for program in "$source"/examples/*.cpp; do
  lines=$(wc -l <"$program")
  [ "$lines" -lt 80 ] || { echo "$program has $lines lines; an example stays under 80"; exit 1; }
done

# Mars is small enough to build here, at a low level.
"$work/prefix/bin/tellurion" build "$work/mars.tdb" "$source/data/mars/mola_dem_4ppd.tif" --kind elevation --max-level 2
olympus=$("$work/examples/height_at" "$work/mars.tdb" 18.65 -133.8)
echo "Olympus Mons: $olympus"
awk -v h="${olympus%% *}" 'BEGIN { exit !(h > 12000 && h < 22000) }' || { echo "that is not the height of Olympus Mons"; exit 1; }
"$work/examples/snapshot" "$work/mars.tdb" "$work/mars.png"
size=$(stat -c %s "$work/mars.png")
[ "$size" -gt 10000 ] || { echo "mars.png has only $size bytes: a blank picture?"; exit 1; }
echo "2 examples built against the installed library and ran"
