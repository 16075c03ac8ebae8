# Relaxation up to where methods diverge: crosses are runs that were reported to.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_relaxation.csv'
set ylabel "relative L2 error in the field of view"
set xlabel "relaxation"
set output 'cone_beam_relaxation.svg'
set title "Head from 60 views, 6 iterations: error by relaxation"
plot for [i = 0:blocks(file) - 1] file index i using 3:6 with linespoints lw 2 lc i + 1 pt 7 title name(file, i), \
  for [i = 0:blocks(file) - 1] file index i using 3:($16 > 0 ? $6 : NaN) with points pt 2 ps 3 lw 3 lc i + 1 title "reported as divergence"
