# emulator.csv: what a level costs the host, and how far its frame time is from that of the cycle level.
set datafile separator ','
set title "The emulator: error of the frame time by the host's time"
set xlabel "host seconds a frame"
set ylabel "error of the frame time against the cycle level"
set logscale xy
set format y "%g"
set grid
set key outside right
set label "the cycle level has no error by definition: drawn at 1e-4" at graph 0.02, 0.16
column_of(name) = int(system(sprintf("head -1 emulator.csv | tr ',' '\\n' | grep -nx '%s' | cut -d: -f1", name)))
fidelity = column_of("fidelity")
processors = column_of("asic.processors")
floor = 1e-4
error(text) = strlen(text) > 0 ? real(text) : floor  # a reference has none
set xrange [0.01:5]
set yrange [floor / 2:1]
set terminal svg size 900,560 background 'white'
set output 'emulator_error.svg'
plot for [level in "functional approximate cycle"] for [p in "1 4 16"] 'emulator.csv' skip 1 \
  using (strcol(fidelity) eq level && strcol(processors) eq p ? $1 : NaN):(level eq "cycle" ? floor : error(strcol(2)) < floor ? floor : error(strcol(2))) \
  with points pt (p eq "1" ? 7 : p eq "4" ? 5 : 9) \
  lc rgb (level eq "cycle" ? "#404040" : level eq "functional" ? "#0060ad" : "#c04000") \
  title sprintf("%s, p = %s", level, p)
