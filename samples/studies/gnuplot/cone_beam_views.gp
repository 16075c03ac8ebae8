# Few views.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_views.csv'
set output 'cone_beam_views.svg'
set multiplot layout 1, 2 title "Head: error by number of views"
set ylabel "relative L2 error in the field of view"
set xlabel "views of a turn"
set logscale x
eval by_x
unset logscale
set logscale x
unset ylabel
set xlabel "simulated ms, board (filled) and bus (hollow)"
eval by_time
unset logscale
unset multiplot
