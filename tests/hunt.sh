#!/usr/bin/env bash
# Runs the property tests of all rooms with fresh seeds, over and over, and stops at the first failure, whose seed stands in its output.
#   tests/hunt.sh [ROUNDS] [BUILD_DIR]
set -euo pipefail
rounds=${1:-20} build=${2:-build/release}
export TELLURION_TEST_SEED=random
for round in $(seq "$rounds"); do
  for tests in "$build"/bin/{geo,tiling,io,raster,pyramid,scene,render}_tests; do
    "$tests" --gtest_brief=1 >"$build/hunt.log" 2>&1 || { cat "$build/hunt.log"; echo "round $round: $tests failed"; exit 1; }
  done
  echo "round $round of $rounds passed"
done
