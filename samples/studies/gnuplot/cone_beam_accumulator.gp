# Words that are too narrow, and too seldom read.
load '../../script/gnuplot/cone_beam.inc'
file = 'cone_beam_accumulator.csv'
do for [format in "svg png"] {
  eval 'set terminal ' . terminal_of(format)
  set output sprintf('cone_beam_accumulator.%s', format)
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
}
