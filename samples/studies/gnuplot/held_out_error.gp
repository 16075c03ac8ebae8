# held_out.csv: each level's error of the frame time, and of the memory's bandwidth, by what it costs the host.
set datafile separator ','
set title "Scenes that the approximate level was not written with"
set xlabel "host seconds a frame"
set ylabel "error against the cycle level"
set logscale xy
set format y "%g"
set grid
set key below
set label "the cycle level has no error by definition: drawn at 1e-4" at graph 0.02, 0.16
column_of(name) = int(system(sprintf("head -1 held_out.csv | tr ',' '\\n' | grep -nx '%s' | cut -d: -f1", name)))
floor = 1e-4
error(value) = abs(value) < floor ? floor : abs(value)
set xrange [0.02:10]
set yrange [floor / 2:2]
set arrow from 0.05, 0.05 to 10, 0.05 nohead lc rgb "#808080" dt 2
set terminal svg size 900,560 background 'white'
set output 'held_out_error.svg'
plot 'held_out.csv' skip 1 using column_of("functional_s"):(error(column(column_of("functional_time_error")))) \
       with points pt 7 lc rgb "#0060ad" title "functional, time", \
     '' skip 1 using column_of("approximate_s"):(error(column(column_of("time_error")))) \
       with points pt 5 lc rgb "#c04000" title "approximate, time", \
     '' skip 1 using column_of("approximate_s"):(error(column(column_of("bandwidth_error")))) \
       with points pt 4 lc rgb "#c04000" title "approximate, bandwidth", \
     '' skip 1 using column_of("cycle_s"):(error(column(column_of("bandwidth_self")))) \
       with points pt 6 lc rgb "#404040" title "cycle, bandwidth, with queues of one place less", \
     '' skip 1 using column_of("cycle_s"):(floor) with points pt 9 lc rgb "#404040" title "cycle"
