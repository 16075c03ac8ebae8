# Iterations, with noise and without.
load '../../script/gnuplot/cone_beam.inc'
file = 'cone_beam_sart.csv'
set key font ',8' samplen 2 # long names
do for [format in "svg png"] {
  eval 'set terminal ' . terminal_of(format)
  set output sprintf('cone_beam_sart.%s', format)
  set multiplot layout 1, 2 title "Head from 60 views: FDK, SART, OS-SART, SIRT"
  set ylabel "relative L2 error in the field of view"
  set xlabel "iterations (FDK: windows 1, 2, 3)"
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
