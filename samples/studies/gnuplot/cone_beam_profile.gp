# Profiles along x through the middle of the volume.
load '../../../samples/studies/gnuplot/cone_beam.inc'
set datafile commentschars '#' # this chart's points begin with p, too
file = 'cone_beam_profile.csv'
set xlabel "x, mm"
unset key
set terminal svg size 1100,760 background 'white'
set output 'cone_beam_profile.svg'
set multiplot layout 2, 2 title "Along x through the middle: phantom (gray), FDK plain (orange) and normalised (blue)"
do for [i = 0:3] {
  set title name(file, i)
  if (i % 2) { set yrange [0.9:1.15] } else { set yrange [-0.1:1.2] }
  plot file index i using 3:4 with lines lw 3 lc rgb "gray", file index i using 3:5 with lines lw 1 lc rgb "orange", \
       file index i using 3:6 with lines lw 1 lc rgb "blue"
}
unset multiplot
