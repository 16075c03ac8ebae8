# All runs of rendering.csv by step (colour), jitter (hollow), level of detail and datapath (shape), and the Pareto front.
set datafile separator ','
set title "Rendering: error by the board's time of a frame"
set xlabel "simulated ms a frame"
set ylabel "RMSE against a double-precision march at 1/16 voxel"
set logscale xy
set grid
set key outside right
set xrange [1.5:100]
set yrange [0.003:0.1]
set label "128^2, 192^2, 256^2 pixels; thresholds 0.9, 0.98, 1; hollow: jitter" at graph 0.02, 0.04
steps = "0.25 0.5 1 2"
column_of(name) = int(system(sprintf("head -1 rendering.csv | tr ',' '\\n' | grep -nx '%s' | cut -d: -f1", name)))
step = column_of("step")
jitter = column_of("jitter")
level = column_of("level-of-detail")
bits = column_of("asic.datapath")
is(s, j, l, b) = strcol(step) eq s && strcol(jitter) eq j && strcol(level) eq l && strcol(bits) eq b
mark(l, b) = l eq "1" ? 5 : b eq "wide" ? 9 : 7  # filled; one less is hollow
set terminal svg size 1000,640 background 'white'
set output 'rendering_error.svg'
plot for [i = 1:words(steps)] for [j in "off on"] for [l in "0 1"] for [b in "paper wide"] 'rendering.csv' skip 1 \
    using (is(word(steps, i), j, l, b) ? $1 : NaN):2 with points pt mark(l, b) - (j eq "on") ps 0.9 lc i \
    title (j eq "off" ? sprintf("step %s, level %s, %s", word(steps, i), l, b) : ""), \
  "< awk -F, 'NR > 1 && $3 == 1' rendering.csv | sort -t, -g -k1,1" using 1:2 with lines lw 2 lc rgb "#c04000" \
    title "Pareto front"
