#!/bin/sh
# Makes the reference pictures of tests/render/reference_test.cpp anew, by the integrator that takes uniform directions and
# knows no lamp: a minute or two of a machine. Run with the folder of the built programs: make.sh build/release/bin
set -eu
here=$(cd "$(dirname "$0")" && pwd)
programs=$(cd "${1:?the folder of the built programs}" && pwd)
for scene in cornell lamps; do
  source=$here/$scene.json
  [ -f "$source" ] || source=$here/../../../scenes/$scene.json
  "$programs/tessera" render "$source" -o "$here/$scene.exr" --size 32x32 --bounces 3 --filter box --samples 16384 \
    --integrator hemisphere --sampler independent --seed 1
done
