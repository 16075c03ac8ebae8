# All runs of rendering.csv by step and jitter, and the Pareto front.
set datafile separator ','
set title "Rendering: error by the board's time of a frame"
set xlabel "simulated ms a frame"
set ylabel "RMSE against a double-precision march at 1/16 voxel"
set logscale xy
set grid
set key outside below maxcols 4
names = system("head -1 rendering.csv")
column_of(name) = int(system(sprintf("head -1 rendering.csv | tr ',' '\\n' | grep -nx '%s' | cut -d: -f1", name)))
step = column_of("step")
jitter = column_of("jitter")
do for [format in "svg png"] {
  if (format eq "svg") { set terminal svg size 900,620 background 'white' } else { set terminal pngcairo size 900,620 }
  set output 'rendering_error.' . format
  plot for [s in "0.25 0.5 1 2 4"] for [j in "off on"] 'rendering.csv' skip 1 \
      using (strcol(step) eq s && strcol(jitter) eq j ? $1 : NaN):2 with points \
      pt (j eq "on" ? 6 : 7) ps 0.9 title sprintf("step %s%s", s, j eq "on" ? ", jitter" : ""), \
    "< awk -F, 'NR > 1 && $3 == 1' rendering.csv | sort -t, -g -k1,1" using 1:2 with lines lw 2 lc rgb "#c04000" \
      title "Pareto front"
}
