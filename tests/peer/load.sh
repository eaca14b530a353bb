#!/usr/bin/env bash
# What a scene costs before its first ray, here and in Blender: tessera-scenes' pottery read, its pictures decoded, its hierarchy built, by turns
# with Blender's import of the same file and Cycles' synchronization. The least of several rounds, from the page cache; starting up is left out.
#   tests/peer/load.sh [--bin FOLDER] [--rounds N] [--threads N]
# --bin: programs that are built already; else a release is built in build/bench. tests/peer/run.sh gets Blender.
set -euo pipefail
cd "$(dirname "$0")/../.."

bin=
rounds=3
threads=$(nproc)
while [ $# -gt 0 ]; do
  case "$1" in
    --bin) bin=${2:?--bin needs a folder}; shift 2 ;;
    --rounds) rounds=${2:?--rounds needs a number}; shift 2 ;;
    --threads) threads=${2:?--threads needs a number}; shift 2 ;;
    -h | --help) sed -n '2,5s/^# \?//p' "$0"; exit 0 ;;
    *) printf 'load.sh: unknown option "%s"\n' "$1" >&2; exit 2 ;;
  esac
done
if [ -z "$bin" ]; then
  cmake -G Ninja -S . -B build/bench -DCMAKE_BUILD_TYPE=Release -DTESSERA_TESTS=ON >/dev/null
  cmake --build build/bench --target tessera-scenes bench_load_once -- --quiet
  bin=build/bench/bin
fi

folder=build/peer/load
mkdir -p "$folder"
"$bin"/tessera-scenes pottery "$folder"
: >"$folder/ours"
: >"$folder/theirs"
for ((round = 0; round < rounds; ++round)); do
  "$bin"/bench_load_once "$folder/pottery.glb" "$threads" >>"$folder/ours"
  # Another Python first on the PATH would keep Blender from its numpy.
  PATH=/usr/bin:/bin blender -b --factory-startup --python-exit-code 1 -P tests/peer/blender/load.py -- \
    "$folder/pottery.glb" "$folder/blender.exr" "$threads" 2>"$folder/blender.err" | sed -n 's/^measured //p' >>"$folder/theirs"
done

least() {
  awk -v name="$1" '
    { both = $1 + $2; if (NR == 1 || both < all) { first = $1; second = $2; all = both }
      if (NR == 1 || $3 < cpu) cpu = $3; if ($4 > memory) memory = $4 }
    END { printf "%-22s %7.2f s %7.2f s %7.2f s %9.2f s %7.0f MiB\n", name, first, second, all, cpu, memory }' "$folder/$2"
}
printf '%-22s %9s %9s %9s %11s %11s\n' '' read build both 'CPU time' 'at most'
least Tessera ours
least 'Blender, import · sync' theirs
