# Variance of uniform directions against the number of reflections in a closed furnace.
width = 700; height = 440
load "scenes/report/plots/style.gp"
set output folder."/furnace.png"
data = folder."/furnace.tsv"
set logscale y
set format y "%.0e"
set title "Uniform directions in a closed furnace"
set xlabel "reflections"
set ylabel "variance of a sample"
set key bottom right
set xrange [0.5:16.5]
rho(i) = word("0.5 0.8 0.866 0.95", i)
plot for [i=1:4] data index i-1 using 2:6 with lines lc rgb colors[i] notitle, \
  for [i=1:4] data index i-1 using 2:5 with points pt 7 ps 1.2 lc rgb colors[i] title "ρ = ".rho(i)
