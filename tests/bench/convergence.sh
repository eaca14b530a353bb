#!/usr/bin/env bash
# Error against samples, Owen-scrambled Sobol' beside independent numbers: convergence.sh [SCENE.json …], else the ready scenes. Prints a
# Markdown table: relMSE by samples, and the slope of log RMSE over log samples by least squares; -1/2 is plain Monte Carlo's. Draws the
# same to build/convergence/convergence.png where gnuplot is there. Counts, not times: a busy machine does not change them.
set -euo pipefail
cd "$(dirname "$0")/../.."
cmake -G Ninja -S . -B build/bench -DCMAKE_BUILD_TYPE=Release -DTESSERA_TESTS=ON >/dev/null
cmake --build build/bench --target tessera tessera-server tessera-worker tessera-statistics -- --quiet
bin=build/bench/bin
out=build/convergence
counts=4,16,64,256
mkdir -p "$out"
if [ $# -eq 0 ]; then
  cmake --build build/bench --target tessera-scenes -- --quiet
  "$bin/tessera-scenes" lake "$out/scenes" >/dev/null
  set -- scenes/{cornell,cornell-glass,veach-mis,material-lineup,interior,bokeh,panorama,caustics}.json "$out/scenes/lake.json"
fi
: >"$out/points.tsv"

printf '| Scene | Numbers | relMSE with %s samples | Slope of RMSE |\n|---|---|---|---|\n' "${counts//,/ · }"
for scene in "$@"; do
  name=$(basename "$scene" .json)
  # wedge PART ARGUMENTS…: pictures in $out/NAME/PART
  wedge() {
    "$bin/tessera" wedge "$scene" -o "$out/$name.$1.png" --exr-dir "$out/$name/$1" --workers 1 --size 64x48 "${@:2}" >"$out/$name.log" 2>&1 ||
      { cat "$out/$name.log" >&2; exit 1; }
  }
  rm -rf "${out:?}/$name"
  wedge truth --samples 1024 --vary seed=101,102,103,104,105,106,107,108
  wedge tried --vary sampler=independent,sobol_owen --vary samples=$counts --vary seed=1,2,3,4
  "$bin/tessera-statistics" errors "$out/$name"/tried/*.exr --reference "$out/$name"/truth/*.exr >"$out/$name.tsv"
  # Columns are found by their names.
  { head -n 1 "$out/$name.tsv" && tail -n +2 "$out/$name.tsv" | sort -t $'\t' -k5,5n; } | awk -F '\t' -v scene="$name" -v points="$out/points.tsv" '
    /^#/ { sub(/^#/, ""); for (i = 1; i <= NF; i++) column[$i] = i; next }
    { sampler = $column["sampler"]; error = $column["relmse"]
      print scene "\t" sampler "\t" $column["samples"] "\t" error >>points
      x = log($column["samples"]); y = log(error) / 2
      n[sampler]++; sx[sampler] += x; sy[sampler] += y; sxx[sampler] += x * x; sxy[sampler] += x * y
      cells[sampler] = cells[sampler] (n[sampler] > 1 ? " · " : "") sprintf("%.2g", error) }
    END {
      for (s in n) {
        slope = (n[s] * sxy[s] - sx[s] * sy[s]) / (n[s] * sxx[s] - sx[s] * sx[s])
        printf "| %s | %s | %s | %.2f |\n", scene, s, cells[s], slope
      }
    }' | sort
done
# Lines join what stands together.
sort -t $'\t' -k1,1 -k2,2 -k3,3n -o "$out/points.tsv" "$out/points.tsv"
if command -v gnuplot >/dev/null; then gnuplot -e "folder='$out'" tests/bench/convergence.gp; fi
