# Truncated projections.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_truncation.csv'
set output 'cone_beam_truncation.svg'
set multiplot layout 1, 2 title "Head wider than the detector: error by the part of its width that is seen"
set ylabel "relative L2 error in the field of view"
set xlabel "part of the width that is seen"
set yrange [0:*]
eval by_x
unset logscale
set logscale x
unset ylabel
set xlabel "simulated ms, board (filled) and bus (hollow)"
eval by_time
unset logscale
unset multiplot
