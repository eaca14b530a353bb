# relMSE against samples a pixel, a scene a panel.
width = 1100; height = 900  # of nine panels
load "scenes/report/plots/style.gp"
set output folder."/convergence.png"
data = folder."/points.tsv"
scenes = system("cut -f 1 ".data." | uniq")
rows = (words(scenes) + 2) / 3
stats data using 4 nooutput name "error"
set multiplot layout rows,3
set logscale xy
set logscale x 4
set format y "%.0e"
set xrange [3:340]
set yrange [error_min / 2:error_max * 2]
set xlabel "samples a pixel"
set ylabel "relMSE"
set key bottom left
of(name, sampler) = strcol(1) eq name && strcol(2) eq sampler
do for [name in scenes] {
  set title name
  # Half the power of RMSE is plain Monte Carlo's: relMSE falls as one over the samples.
  stats data using (of(name, "independent") && $3 == 4 ? $4 : 1/0) nooutput name "start"
  plot 4 * start_max / x with lines lc rgb "#bbbbbb" dt 2 title "one over the samples", \
    data using (of(name, "independent") ? $3 : 1/0):4 with linespoints pt 7 lw 1.5 lc rgb colors[1] title "independent", \
    data using (of(name, "sobol_owen") ? $3 : 1/0):4 with linespoints pt 7 lw 1.5 lc rgb colors[6] title "sobol_owen"
}
unset multiplot
