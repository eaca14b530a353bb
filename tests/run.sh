#!/usr/bin/env bash
# Installs what the tests need, builds, and runs them all; ends with ctest's summary.
#   tests/run.sh            the tests, warnings being errors
#   tests/run.sh --checks   before them: formatting, clang-tidy, ASan and UBSan over all tests, TSan over all that has threads
#   tests/run.sh --checks=format,tidy,asan,tsan   before them: just the checks that are named
# (The house's rules, such as that includes run one way only, are tests like the others: tests/unit/house.)
set -euo pipefail
cd "$(dirname "$0")/.."

checks=
for argument in "$@"; do
  case "$argument" in
    --checks) checks=format,tidy,asan,tsan ;;
    --checks=*) checks=${argument#--checks=} ;;
    -h | --help) sed -n '2,6s/^# \?//p' "$0"; exit 0 ;;
    *) echo "tests/run.sh: unknown argument \"$argument\" (expected --checks)" >&2; exit 2 ;;
  esac
done
for check in ${checks//,/ }; do
  case "$check" in
    format | tidy | asan | tsan) ;;
    *) echo "tests/run.sh: unknown check \"$check\" (expected format, tidy, asan or tsan)" >&2; exit 2 ;;
  esac
done
has() { [[ ",$checks," == *",$1,"* ]]; }

jobs=$(nproc)
say() { printf '\n== %s\n' "$*"; }
configure() { cmake --preset "$1" >"build/configure-$1.log" 2>&1 || { cat "build/configure-$1.log" >&2; exit 1; }; }
build() { configure "$1"; cmake --build --preset "$@"; }

mkdir -p build
if [ -n "$checks" ]; then deploy/packages.sh build test check; else deploy/packages.sh build test; fi

if has format; then
  say "Formatting"
  git ls-files -z '*.cpp' '*.hpp' | xargs -0 clang-format --dry-run --Werror
fi
if has tidy; then
  say "clang-tidy"
  configure dev
  tests/tidy.sh build/dev "$jobs"
fi
if has asan; then
  say "AddressSanitizer and UndefinedBehaviorSanitizer over all tests"
  build asan
  ctest --preset asan -j "$jobs"
fi
if has tsan; then
  say "ThreadSanitizer over all that has threads"
  build tsan --target threaded_tests
  ctest --preset tsan -j "$jobs"
fi

say "Tests"
build dev
ctest --preset dev -j "$jobs"
