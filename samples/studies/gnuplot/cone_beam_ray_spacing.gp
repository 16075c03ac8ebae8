# Pixels larger and smaller than voxels.
load '../../../samples/studies/gnuplot/cone_beam.inc'
file = 'cone_beam_ray_spacing.csv'
set output 'cone_beam_ray_spacing.svg'
set multiplot layout 1, 2 title "Head: error by the distance of rays"
set ylabel "relative L2 error in the field of view"
set xlabel "pixel over voxel, at the axis"
set yrange [0:*]
eval by_x
unset logscale
set logscale x
unset ylabel
set xlabel "simulated ms, board (filled) and bus (hollow)"
eval by_time
unset logscale
unset multiplot
