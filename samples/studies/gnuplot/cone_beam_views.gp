# Few views.
load '../../script/gnuplot/cone_beam.inc'
file = 'cone_beam_views.csv'
do for [format in "svg png"] {
  eval 'set terminal ' . terminal_of(format)
  set output sprintf('cone_beam_views.%s', format)
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
}
