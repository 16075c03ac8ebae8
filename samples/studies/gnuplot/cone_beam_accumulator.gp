# Words that are too narrow, and too seldom read.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_accumulator.csv'
set output 'cone_beam_accumulator.svg'
set multiplot layout 1, 2 title "Head from 120 views: error by words of the accumulator, and by how often they are read"
set logscale x
set yrange [0.28:0.7]
set ylabel "relative L2 error in the field of view"
set xlabel "x"
eval by_x
unset ylabel
set xlabel "simulated ms, board (filled) and bus (hollow)"
eval by_time
unset multiplot
