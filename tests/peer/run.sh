#!/usr/bin/env bash
# Renders scenes that others made, and that Debian's Blender writes, here and in Cycles, and compares the pictures: README.md.
#   tests/peer/run.sh [--no-install] [--bin FOLDER] [pairs.py's options: --samples N, --size WxH, --threads N, --only NAME …]
#   tests/peer/run.sh --duel [--no-install] [--bin FOLDER] [duel.py's options: those, --seeds N, …]: speed and noise, from many seeds
# What is lacking is got from Debian and npm; with --no-install it is said, and nothing is installed. --bin: programs that are built already;
# else a release with the tests' programs is built in build/bench. Scenes, pictures and sheets are left in build/peer.
set -euo pipefail
cd "$(dirname "$0")/../.."

install=1
bin=
duel=
while [ $# -gt 0 ]; do
  case "$1" in
    --no-install) install=; shift ;;
    --duel) duel=1; shift ;;
    --bin) bin=${2:?--bin needs a folder}; shift 2 ;;
    -h | --help) sed -n '2,6s/^# \?//p' "$0"; exit 0 ;;
    *) break ;;
  esac
done

[ -z "$install" ] || deploy/packages.sh peer
[ -z "$install" ] || [ -n "$bin" ] || deploy/packages.sh build test
lacking=()
programs=(blender python3)
[ -n "$duel" ] || programs+=(node npm)
for program in "${programs[@]}"; do command -v "$program" >/dev/null || lacking+=("$program"); done
/usr/bin/python3 -c 'import numpy' 2>/dev/null || lacking+=(python3-numpy)
folder=build/peer
assets=$folder/npm
packages=()
[ -n "$duel" ] || packages=(@pmndrs/assets @gltf-transform/core @gltf-transform/extensions draco3dgltf)
for package in "${packages[@]}"; do [ -d "$assets/node_modules/$package" ] || lacking+=("npm's $package"); done
if [ ${#lacking[@]} -gt 0 ] && [ -n "$install" ] && [ -z "$duel" ] && command -v npm >/dev/null; then
  mkdir -p "$assets"
  npm install --silent --no-audit --no-fund --prefix "$assets" "${packages[@]}"
  mapfile -t lacking < <(printf '%s\n' "${lacking[@]}" | grep -v "^npm's ")
fi
if [ ${#lacking[@]} -gt 0 ]; then
  printf 'tests/peer/run.sh: lacking:'; printf ' %s;' "${lacking[@]}"; [ -n "$install" ] || printf ' without --no-install it is got'; echo
  exit 2
fi >&2

if [ -z "$bin" ]; then
  cmake -G Ninja -S . -B build/bench -DCMAKE_BUILD_TYPE=Release -DTESSERA_TESTS=ON >/dev/null
  cmake --build build/bench --target tessera tessera-server tessera-worker peer_compare peer_errors bench_load_once -- --quiet
  bin=build/bench/bin
fi

[ -z "$duel" ] || exec python3 tests/peer/duel.py "$folder/duel" --bin "$bin" "$@"
mkdir -p "$folder/written"
node tests/peer/unpack.mjs "$assets" models/{bunny,suzi,pmndrs}.glb hdri/{studio,sunset,forest,lobby,park}.exr
# Another Python first on the PATH would keep Blender from its numpy.
PATH=/usr/bin:/bin blender -b --factory-startup --python-exit-code 1 -P tests/peer/blender/write_scenes.py -- "$folder/written" \
  >"$folder/written.log" 2>&1 || { cat "$folder/written.log" >&2; exit 1; }
python3 tests/peer/pairs.py "$folder" --bin "$bin" "$@"
