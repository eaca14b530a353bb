# Error of the report's grid against path samples and against light samples.
width = 1000; height = 420
load "scenes/report/plots/style.gp"
set output folder."/variance.png"
data = folder."/variance.tsv"
set multiplot layout 1,2
set logscale xy
set format y "10^{%T}"
set format y "%.0e"
set title "Mean squared error falls as 1 / path samples"
set xlabel "path samples"
set ylabel "mean squared error"
set xrange [0.7:90]
set xtics (1, 4, 16, 64)
first = 0
stats data using ($5 == 1 && $3 == 1 ? $8 : 1/0) nooutput
start = STATS_mean
plot start / x with lines dt 2 lc rgb "#555555" title "1 / samples", \
  for [i=1:3] data using ($3 == 4**(i-1) ? $5 : 1/0):8:9 with yerrorbars pt 7 ps 1.2 lc rgb colors[i] \
    title sprintf("%d light sample%s", 4**(i-1), i == 1 ? "" : "s")
set title "and as a + b / light samples"
set xlabel "light samples at each hit"
set ylabel "samples × mean squared error"
unset logscale
set logscale x
set format y "%g"
set xrange [0.7:24]
set yrange [0:*]
set xtics (1, 4, 16)
a = start / 2; b = start / 2
f(x) = a + b / x
set fit quiet logfile "/dev/null"
fit f(x) data using ($5 == 64 ? $3 : 1/0):12 via a, b
plot f(x) with lines dt 2 lc rgb "#555555" title sprintf("%.3g + %.3g / N", a, b), \
  data using ($5 == 64 ? $3 : 1/0):12 with points pt 7 ps 1.3 lc rgb colors[1] title "measured, 64 samples"
unset multiplot
