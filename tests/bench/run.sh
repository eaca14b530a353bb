#!/usr/bin/env bash
# Measures: each figure is a ratio within one run, or a count, beside what it should reach. run.sh [--quick]
set -euo pipefail
cd "$(dirname "$0")/../.."
deploy/packages.sh build test
cmake -G Ninja -S . -B build/bench -DCMAKE_BUILD_TYPE=Release -DTESSERA_TESTS=ON >/dev/null
cmake --build build/bench --target tessera tessera-server tessera-worker bench_sampler bench_image bench_render bench_direct bench_lights bench_load bench_schedule bench_coordinator bench_submit bench_farm house_test -- --quiet
export TESSERA_SOURCE_DIR=$PWD TESSERA_BIN_DIR=$PWD/build/bench/bin
"$TESSERA_BIN_DIR"/house_test --gtest_brief=1 --gtest_filter='*contracted*'
for bench in bench_sampler bench_image bench_render "bench_lights ${1:-}" "bench_load ${1:-}" "bench_schedule ${1:-}" "bench_coordinator ${1:-}" "bench_submit ${1:-}" "bench_farm ${1:-}"; do
  printf '\n== %s\n' "$bench"
  # shellcheck disable=SC2086
  "$TESSERA_BIN_DIR"/$bench
done
