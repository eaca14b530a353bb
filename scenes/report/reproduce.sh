#!/usr/bin/env bash
# Renders and measures all that README.md of this folder says: reproduce.sh [FOLDER]. Pictures, tables (.tsv) and plots go to
# FOLDER, build/report unless named. Under ten minutes on two cores, once the programs are built.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m "${1:-build/report}")
here=scenes/report

deploy/packages.sh build test plot
cmake -G Ninja -S . -B build/bench -DCMAKE_BUILD_TYPE=Release -DTESSERA_TESTS=ON >/dev/null
cmake --build build/bench --target tessera tessera-server tessera-worker tessera-statistics bench_sampler -- --quiet
bin=$PWD/build/bench/bin
rm -rf "$out"
mkdir -p "$out"
began=$SECONDS
say() { printf '\n== %s   (%d s)\n' "$*" $((SECONDS - began)); }
# wedge NAME SCENE ARGUMENTS…: pictures in $out/NAME, the sheet beside it; on a farm of its own, whichever server is set.
wedge() { "$bin/tessera" wedge "$here/$2.json" -o "$out/$1.png" --exr-dir "$out/$1" --workers 1 "${@:3}" >"$out/$1.log" 2>&1 ||
  { cat "$out/$1.log" >&2; exit 1; }; }
statistics() { "$bin/tessera-statistics" "$@"; }
plot() { gnuplot -e "folder='$out'" "$here/plots/$1.gp"; }
show() { grep -v '^# ' "$1" | column -t -s $'\t'; grep '^# ' "$1" || true; }

# For what is about plain random numbers: of the generators addressed by pixel and sample, one that costs little.
random=pcg
few=(--size 96x96)

say "The figure: path samples to the right, light samples downwards"
wedge figure report --integrator hemisphere_lights --sampler "$random" --vary samples=1,4,16,64 --vary light_samples=1,4,16

say "1. The mean is the same in every cell, and the variance falls along both axes"
wedge truth report "${few[@]}" --integrator path --samples 512 --vary seed=101,102,103,104,105,106,107,108
wedge cells report "${few[@]}" --integrator hemisphere_lights --sampler "$random" \
  --vary samples=1,4,16,64 --vary light_samples=1,4,16 --vary seed=1,2,3,4,5,6,7,8
statistics means "$out"/cells/*.exr --reference "$out"/truth/*.exr >"$out/means.tsv" || means_differ=$?
statistics errors "$out"/cells/*.exr --reference "$out"/truth/*.exr >"$out/variance.tsv"
show "$out/means.tsv"
show "$out/variance.tsv"
plot variance
[ -z "${means_differ:-}" ] || { echo "reproduce.sh: the comparison of means failed" >&2; exit "$means_differ"; }

say "2. Under a constant sky the variance is ρ²/3 with uniform directions, 0 by the cosine; in a furnace it diverges from ρ = √3/2 on"
: >"$out/sky.tsv"
for rho in 0.2 0.5 0.8 1.0; do
  wedge "sky-$rho" sky --vary integrator=hemisphere,cosine --vary "materials.plane.reflectance=$rho" --sampler "$random"
  statistics pictures "$out/sky-$rho"/*.exr | awk -v rho="$rho" 'BEGIN { FS = OFS = "\t" }
    /^#/ { next } { print rho, $1, $8, $9, ($1 == "hemisphere" ? rho * rho / 3 : 0) }' >>"$out/sky.tsv"
done
printf '%s\t%s\t%s\t%s\t%s\n' '#rho' integrator mean variance theory | cat - "$out/sky.tsv" | column -t -s $'\t'
: >"$out/furnace.tsv"
for rho in 0.5 0.8 0.866 0.95; do
  wedge "furnace-$rho" furnace --vary bounces=0,1,3,5,7,11,15 --vary "materials.wall.reflectance=$rho" --sampler "$random"
  # After n reflections X = 1 + w·X', w = 2ρ·cos θ: the mean and second moment follow from those after n − 1.
  statistics pictures "$out/furnace-$rho"/*.exr | awk -v rho="$rho" 'BEGIN { FS = OFS = "\t" }
    /^#/ { next }
    { m = s = 1
      for (n = 0; n <= $4; n++) { s = 1 + 2 * rho * m + 4 * rho * rho / 3 * s; m = 1 + rho * m }
      print rho, $4 + 1, $8, m, $9, s - m * m }' | sort -k2,2n >>"$out/furnace.tsv"
  printf '\n\n' >>"$out/furnace.tsv"
done
printf '%s\t%s\t%s\t%s\t%s\t%s\n' '#rho' reflections mean theory variance theory | cat - "$out/furnace.tsv" | column -t -s $'\t'
plot furnace

say "3. What a generator costs, a number and a sample"
"$bin/bench_sampler" --ratios | tee "$out/generators.txt"

say "4. Threads"
cores=$(nproc)
printf '#kind\tcount\tseconds\n' >"$out/threads.tsv"
for ((n = 1; n <= cores; n = n < cores && 2 * n > cores ? cores : 2 * n)); do
  for kind in threads workers; do
    if [ $kind = threads ]; then how=(--workers 1 --threads "$n"); else how=(--workers "$n" --threads 1); fi
    seconds=$("$bin/tessera" render scenes/cornell.json --samples 48 -o "$out/threads.exr" "${how[@]}" --json 2>/dev/null |
      sed -n 's/.*"render_seconds": *\([0-9.e+-]*\).*/\1/p' | tail -n 1)
    printf '%s\t%d\t%s\n' "$kind" "$n" "$seconds" >>"$out/threads.tsv"
  done
done
show "$out/threads.tsv"

say "5. Error at equal time"
wedge race report "${few[@]}" --vary integrator=hemisphere,cosine,hemisphere_lights,path --vary samples=4,16,64,256 \
  --vary sampler=mt19937,xorshift,pcg,independent,sobol,sobol_owen
statistics errors "$out"/race/*.exr --reference "$out"/truth/*.exr >"$out/race.tsv"
plot race
# Slope of log error against log time by least squares; and the time for a root mean square error of .05 on that line.
awk 'BEGIN { FS = "\t"; printf "%-18s %-12s %12s %22s\n", "integrator", "sampler", "slope", "seconds to RMSE .05" }
  /^#/ { next }
  { k = $1 "\t" $2; x = log($7); y = log($8) / 2; n[k]++; sx[k] += x; sy[k] += y; sxx[k] += x * x; sxy[k] += x * y }
  END { for (k in n) { b = (n[k] * sxy[k] - sx[k] * sy[k]) / (n[k] * sxx[k] - sx[k] ^ 2); a = (sy[k] - b * sx[k]) / n[k]
      split(k, name, "\t"); printf "%-18s %-12s %12.2f %22.3g\n", name[1], name[2], b, exp((log(.05) - a) / b) | "sort" } }' \
  "$out/race.tsv" | tee "$out/slopes.txt"

say "Done: $out"
