# Host seconds against error of one reconstruction, by Google Benchmark's table: 1 name, 3 seconds of wall clock, 11 cpu_s, 12 relative_l2
set datafile separator ','
set title "FDK of 256^3 from 256^2 pixels, head of Shepp and Logan: error by the host's time"
set xlabel "CPU seconds of the host, all cores"
set ylabel "relative L2 error"
set logscale x
set yrange [0:*]
set grid
set key outside below maxcols 1
column_of(what) = int(system(sprintf("grep -m 1 '^name' cone_beam_trade.csv | tr -d '\"' | tr ',' '\\n' | grep -nx %s | cut -d: -f1", what)))
cpu = column_of("cpu_s")
error = column_of("relative_l2")
table(pattern) = sprintf("< grep '%s' cone_beam_trade.csv", pattern)
$foreign << EOD
23,0.17
EOD
set terminal svg size 900,560 background 'white'
set output 'cone_beam_trade.svg'
plot table('^"cone_beam_trade/views:[0-9]*/rays:1/half_steps:2/window:0') using cpu:error with linespoints lw 2 pt 7 \
    title "board's rays, defaults: 90, 180, 360 views", \
  table('^"cone_beam_trade/views:360/rays:1/half_steps:2/window:1') using cpu:error with points pt 5 ps 1.3 title "360 views, Shepp-Logan window", \
  table('^"cone_beam_trade/views:360/rays:1/half_steps:4') using cpu:error with points pt 9 ps 1.3 title "360 views, steps of 2 voxels", \
  table('^"cone_beam_trade/views:360/rays:1/half_steps:1') using cpu:error with points pt 11 ps 1.3 title "360 views, steps of 1/2 voxel", \
  table('^"cone_beam_trade/views:360/rays:2') using cpu:error with points pt 13 ps 1.3 title "360 views, 2 x 2 rays a pixel", \
  table('^"cone_beam_trade_reference') using cpu:error with linespoints lw 2 pt 6 \
    title "double precision, voxel by voxel: 90, 180, 360 views", \
  $foreign using 1:2 with points pt 3 ps 2 lw 2 title "plastimatch, nearest neighbours, 360 views (as its user measured it)"
