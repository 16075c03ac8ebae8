# Iterations, with noise and without.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_sart.csv'
set key font ',8' samplen 2 # long names
set output 'cone_beam_sart.svg'
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
