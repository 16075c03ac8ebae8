# All runs of rendering.csv by step and jitter, and the Pareto front.
set datafile separator ','
set title "Rendering: error by the board's time of a frame"
set xlabel "simulated ms a frame"
set ylabel "RMSE against a double-precision march at 1/16 voxel"
set logscale xy
set grid
set key outside right
set xrange [1.5:100]
set yrange [0.003:0.1]
set label "images of 128^2, 192^2 and 256^2, thresholds of 0.9, 0.98 and 1" at graph 0.02, 0.04
steps = "0.25 0.5 1 2 4"
column_of(name) = int(system(sprintf("head -1 rendering.csv | tr ',' '\\n' | grep -nx '%s' | cut -d: -f1", name)))
step = column_of("step")
jitter = column_of("jitter")
do for [format in "svg png"] {
  if (format eq "svg") { set terminal svg size 900,620 background 'white' } else { set terminal pngcairo size 900,620 }
  set output 'rendering_error.' . format
  plot for [i = 1:words(steps)] for [j in "off on"] 'rendering.csv' skip 1 \
      using (strcol(step) eq word(steps, i) && strcol(jitter) eq j ? $1 : NaN):2 with points \
      pt (j eq "on" ? 6 : 7) ps 0.9 lc i title sprintf("step %s%s", word(steps, i), j eq "on" ? ", jitter" : ""), \
    "< awk -F, 'NR > 1 && $3 == 1' rendering.csv | sort -t, -g -k1,1" using 1:2 with lines lw 2 lc rgb "#c04000" \
      title "Pareto front"
}
