# Error against rendering time, an integrator a panel.
width = 1100; height = 820
load "scenes/report/plots/style.gp"
set output folder."/race.png"
data = folder."/race.tsv"
stats data using (sqrt($8)) nooutput name "error"
stats data using 7 nooutput name "time"
set yrange [error_min / 1.5:error_max * 1.5]
set xrange [time_min / 1.3:time_max * 1.3]
set multiplot layout 2,2
set logscale xy
set xlabel "CPU seconds"
set ylabel "root mean square error"
set key bottom left
integrators = "hemisphere cosine hemisphere_lights path"
samplers = "mt19937 xorshift pcg independent sobol sobol_owen"
do for [k=1:4] {
  name = word(integrators, k)
  set title name
  plot for [i=1:6] data using (strcol(1) eq name && strcol(2) eq word(samplers, i) ? $7 : 1/0):(sqrt($8)) \
    with linespoints pt 7 lw 1.5 lc rgb colors[i] title word(samplers, i)
}
unset multiplot
