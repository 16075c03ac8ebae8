# Discs along the axis of rotation: means within 34 mm of it, and the phantom.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_axial_profile.csv'
set ylabel "1/mm"
set xlabel "z, mm"
set output 'cone_beam_axial_profile.svg'
set title "Discs across the axis by FDK: mean of each slice within 34 mm, by full cone angle"
plot file index 0 using 3:4 with lines lw 3 lc rgb "gray" title "phantom", \
  for [i = 0:blocks(file) - 1] file index i using 3:6 with lines lw 2 lc i + 1 title name(file, i)
