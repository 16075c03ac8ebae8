# Discs, which a cone smears into one another.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_cone_angle.csv'
set output 'cone_beam_cone_angle.svg'
set multiplot layout 1, 2 title "Discs across the axis: error by cone angle"
set ylabel "relative L2 error in the field of view"
set xlabel "full cone angle, degrees"
set yrange [0:*]
eval by_x
unset logscale
set logscale x
unset ylabel
set xlabel "simulated ms, board (filled) and bus (hollow)"
eval by_time
unset logscale
unset multiplot
