# Passes of lighting.csv by mode; each line is k = 1, 2, 4, 8, 16 at steps of half a voxel.
set datafile separator ','
set title "Lighting: error of a lamp in an absorber by the board's time of a pass"
set xlabel "simulated ms a pass"
set ylabel "error of irradiance (RMS, relative to the closed form)"
set logscale xy
set grid
set key outside below maxcols 2
is(albedo, rules, datapath, s) = strcol(4) eq albedo && strcol(5) eq rules && strcol(6) eq datapath && strcol(8) eq s
bits(albedo, datapath) = datapath eq "wide" ? "24 bits" : albedo eq "low" ? "8 bits" : "4 bits"
set terminal svg size 900,640 background 'white'
set output 'lighting_error.svg'
plot for [albedo in "low high"] for [rules in "conserving printed"] for [datapath in "paper wide"] 'lighting.csv' skip 1 \
    using (is(albedo, rules, datapath, "0.5") ? $1 : NaN):2 with linespoints dt 1 + (rules eq "printed") lw 1.5 \
    title sprintf("%s albedo, %s, %s", albedo, rules, bits(albedo, datapath)), \
  'lighting.csv' skip 1 using (strcol(8) eq "2" ? $1 : NaN):2 with points pt 2 ps 0.7 lc rgb "gray" title "all of these at steps of 2", \
  "< awk -F, 'NR > 1 && $3 == 1' lighting.csv | sort -t, -g -k1,1" using 1:2 with lines lw 4 lc rgb "#60c04000" \
    title "Pareto front"
