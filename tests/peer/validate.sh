#!/usr/bin/env bash
# Has npm's gltf-validator look at every glTF file that we write: tessera-scenes', the ready scenes', the good ones of the fuzz corpus.
#   tests/peer/validate.sh [--bin FOLDER]
# --bin: programs that are built already; else a release of tessera-scenes is built in build/bench. The validator goes into build/peer/npm.
set -euo pipefail
cd "$(dirname "$0")/../.."

bin=
case "${1:-}" in
  '') ;;
  --bin) bin=${2:?--bin needs a folder} ;;
  *) sed -n '2,4s/^# \?//p' "$0"; exit 2 ;;
esac
if [ -z "$bin" ]; then
  cmake -G Ninja -S . -B build/bench -DCMAKE_BUILD_TYPE=Release -DTESSERA_TESTS=ON >/dev/null
  cmake --build build/bench --target tessera-scenes -- --quiet
  bin=build/bench/bin
fi

folder=build/peer
mkdir -p "$folder/npm" "$folder/made"
[ -d "$folder/npm/node_modules/gltf-validator" ] || npm install --silent --no-audit --no-fund --prefix "$folder/npm" gltf-validator
"$bin"/tessera-scenes pottery "$folder/made" 20000
"$bin"/tessera-scenes forest "$folder/made" 2000
shopt -s extglob
node tests/peer/validate.mjs "$folder/npm" "$folder"/made/*.gl* scenes/*.gltf tests/data/fuzz/gltf/!(bad-*)
