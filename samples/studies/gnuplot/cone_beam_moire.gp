# The ripple of rays in what should be even, and what the hat of the interpolation leaves of a wave as long as their distance.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_moire.csv'
set ylabel "ripple: RMS of what was left / wanted - 1"
set xlabel "distance of rays over voxel, at the axis"
set logscale y
set format y "10^{%T}"
set yrange [5e-5:2]
set xrange [0.35:3.05]
set samples 1000
set output 'cone_beam_moire.svg'
set title "Moire of splatted rays"
plot for [i = 0:blocks(file) - 1] file index i using 3:4 with linespoints lw 2 lc i + 1 pt 7 title name(file, i), \
  (sin(pi / x) / (pi / x)) ** 2 with lines dt 2 lc rgb "gray" title "sinc^2 of the rays' wave"
