#!/usr/bin/env bash
# Installs what the tests need, builds, and runs them all; ends with ctest's summary.
#   tests/run.sh            the tests, warnings being errors
#   tests/run.sh --checks   before them: formatting, clang-tidy, ASan and UBSan over all tests, TSan over all that has threads
# (That includes run one way only and that the coordinator links no Embree are tests like the others: tests/unit/house.)
set -euo pipefail
cd "$(dirname "$0")/.."

checks=0
for argument in "$@"; do
  case "$argument" in
    --checks) checks=1 ;;
    -h | --help) sed -n '2,5s/^# \?//p' "$0"; exit 0 ;;
    *) echo "tests/run.sh: unknown argument \"$argument\" (expected --checks)" >&2; exit 2 ;;
  esac
done

jobs=$(nproc)
say() { printf '\n== %s\n' "$*"; }
configure() { cmake --preset "$1" >"build/configure-$1.log" 2>&1 || { cat "build/configure-$1.log" >&2; exit 1; }; }
build() { configure "$1"; cmake --build --preset "$@"; }

mkdir -p build
if [ $checks = 1 ]; then deploy/packages.sh build test check; else deploy/packages.sh build test; fi

if [ $checks = 1 ]; then
  say "Formatting"
  git ls-files -z '*.cpp' '*.hpp' | xargs -0 clang-format --dry-run --Werror

  say "clang-tidy"
  configure dev
  tests/tidy.sh build/dev "$jobs"

  say "AddressSanitizer and UndefinedBehaviorSanitizer over all tests"
  build asan
  ctest --preset asan -j "$jobs"

  say "ThreadSanitizer over all that has threads"
  build tsan --target threaded_tests
  ctest --preset tsan -j "$jobs"
fi

say "Tests"
build dev
ctest --preset dev -j "$jobs"
