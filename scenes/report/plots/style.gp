# What all plots share.
set terminal pngcairo noenhanced size width, height font "DejaVu Sans,11" background "#ffffff"
set border 3 lc rgb "#555555"
set tics nomirror
set grid lc rgb "#dddddd" lt 1
set datafile separator "\t"
set key top right reverse Left samplen 2
array colors[6] = ["#d1495b", "#edae49", "#66a182", "#2e4057", "#8d96a3", "#00798c"]
