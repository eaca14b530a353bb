#!/usr/bin/env bash
# From a checkout to a picture: installs what is needed, builds, runs a coordinator and two workers on this machine, and renders
# scenes/cornell.json into cornell.exr and cornell.png at the root of the checkout. Stops what it started.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD

deploy/packages.sh build
if [ -x build/release/bin/tessera ]; then echo "Building what has changed …"; else echo "Building; the first time takes some minutes …"; fi
cmake --preset release >build-configure.log 2>&1 || { cat build-configure.log >&2; rm -f build-configure.log; exit 1; }
rm -f build-configure.log
quiet=(--quiet)
[ ! -t 1 ] || quiet=()  # a terminal shows how far the build is
cmake --build --preset release -- "${quiet[@]}"
bin=$root/build/release/bin

work=$(mktemp -d "${TMPDIR:-/tmp}/tessera-quickstart.XXXXXX")
pids=()
stop() {
  trap - EXIT INT TERM
  # Workers first, so that none is seen waiting for a coordinator that has gone.
  for ((i = ${#pids[@]} - 1; i >= 0; i--)); do kill "${pids[i]}" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$work"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

"$bin/tessera-server" --data "$work/data" --http 127.0.0.1:0 --listen 127.0.0.1:0 >"$work/ready" 2>"$work/server.log" &
pids+=($!)
for _ in $(seq 100); do
  [ -s "$work/ready" ] && break
  kill -0 "${pids[0]}" 2>/dev/null || { echo "The coordinator did not start:" >&2; cat "$work/server.log" >&2; exit 1; }
  sleep 0.1
done
http=$(sed -n 's/.*"http": *"\([^"]*\)".*/\1/p' "$work/ready")
listen=$(sed -n 's/.*"listen": *"\([^"]*\)".*/\1/p' "$work/ready")
[ -n "$http" ] && [ -n "$listen" ] || { echo "The coordinator did not say where it listens:" >&2; cat "$work/server.log" >&2; exit 1; }

threads=$(($(nproc) / 2 > 0 ? $(nproc) / 2 : 1))
for k in 1 2; do
  "$bin/tessera-worker" --server "$listen" --threads "$threads" --name "worker-$k" --cache "$work/cache-$k" 2>"$work/worker-$k.log" &
  pids+=($!)
done
echo "A coordinator runs at http://$http (open it in a browser to watch), with two workers of $threads thread(s) each."

export TESSERA_SERVER="http://$http"
started=$(date +%s.%N)
job=$("$bin/tessera" submit scenes/cornell.json)
"$bin/tessera" watch "$job"
"$bin/tessera" fetch "$job" -o cornell.exr
"$bin/tessera" fetch "$job" -o cornell.png
took=$(awk -v a="$started" -v b="$(date +%s.%N)" 'BEGIN { printf "%.1f", b - a }')

cat <<SAY

Rendered in $took s:
  $root/cornell.exr   linear, 32-bit float, with albedo, normals, depth and variance
  $root/cornell.png   for the screen

What to try next:
  build/release/bin/tessera render scenes/cornell-glass.json -o glass.png --samples 256
  build/release/bin/tessera-server                                   # then open http://127.0.0.1:8420
  build/release/bin/tessera-worker --server 127.0.0.1:8421           # as many as you like, on as many machines
  build/release/bin/tessera submit scenes/cornell.json --samples 1024
SAY
