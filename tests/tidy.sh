#!/usr/bin/env bash
# clang-tidy over the sources of the three programs: tidy.sh BUILD_FOLDER JOBS. The checks stand in .clang-tidy.
# A file whose text, and the text of all of ours it could include, is as it was when it last passed is passed over.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1 jobs=$2
passed=$build/tidy-passed
mkdir -p "$passed"
# One digest of all headers and settings: a change in any of them has every file looked at again.
common=$(git ls-files -z '*.hpp' .clang-tidy cmake CMakeLists.txt | xargs -0 cat | sha256sum | cut -c1-16)
export build passed common

look_at() {
  mark=$passed/$(cat "$1" - <<<"$common" | sha256sum | cut -c1-32)
  [ -e "$mark" ] && exit 0
  if out=$(clang-tidy -p "$build" --quiet --warnings-as-errors='*' \
      --extra-arg=-DBOOST_ASIO_HAS_CO_AWAIT=1 --extra-arg=-DBOOST_ASIO_HAS_STD_COROUTINE=1 \
      --extra-arg=-Wno-unknown-warning-option "$1" 2>/dev/null); then
    touch "$mark"
  else
    printf '%s\n' "$out"
    exit 1
  fi
}
export -f look_at
git ls-files -z 'common/*.cpp' 'server/*.cpp' 'worker/*.cpp' 'client/*.cpp' |
  xargs -0 -n 1 -P "$jobs" bash -c 'look_at "$0"'
