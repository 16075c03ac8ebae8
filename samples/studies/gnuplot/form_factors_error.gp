# Error against rays, with the straight lines that the program fitted in logarithms (form_factors_slopes.csv).
set datafile separator ','
set title "Form factors: error by rays of an estimate"
set xlabel "rays"
set ylabel "error (RMS of F / exact - 1, 16 estimates)"
set logscale x 10
set format x "10^{%T}"
set logscale y
set format y "10^{%T}"
set grid
set key outside below maxcols 3
slope(i) = system(sprintf("awk -F, 'NR == %d { print $3 }' form_factors_slopes.csv", i + 2))
name(i) = system(sprintf("awk -F, 'NR == %d { print $1 }' form_factors_slopes.csv", i + 2))
blocks = int(system("awk 'END { print NR - 1 }' form_factors_slopes.csv"))
set terminal svg size 800,560 background 'white'
set output 'form_factors_error.svg'
plot for [i = 0:blocks - 1] 'form_factors_error.csv' index i using (strcol(2) eq "rays" ? NaN : $2):3 \
  with linespoints lw 2 title sprintf("%s (slope %s)", name(i), slope(i)), \
  0.2 / sqrt(x) with lines dashtype 2 lc rgb "gray" title "random points: -0.5"
