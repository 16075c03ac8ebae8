# cone_beam_front.csv: all ways to reconstruct the same head, by the board's time and by the bus's, and their Pareto fronts.
set datafile separator ','
set logscale x
set grid
set ylabel "relative L2 error in the field of view"
file = 'cone_beam_front.csv'
series = system(sprintf("awk -F, 'NR > 1 { print $1 }' %s | sort -u | tr ' \\n' '~ '", file))
name(i) = system(sprintf("echo '%s' | tr '~' ' '", word(series, i)))
set key at screen 0.97, 0.24 right top vertical maxrows 5 font ",9"
set tmargin at screen 0.92
set bmargin at screen 0.36
set terminal svg size 1100,640 background 'white'
set output 'cone_beam_front.svg'
set multiplot layout 1, 2 title "Head of 64^3: views, size of the detector's pixels, rays a pixel, words, methods"
do for [c = 0:1] {
  set xlabel (c == 0 ? "simulated ms of the board" : "simulated ms of the bus")
  plot for [i = 1:words(series)] file skip 1 using (strcol(1) eq name(i) ? column(3 + c) : NaN):2 with points pt 3 + i ps 0.8 \
      lc i title (c == 0 ? name(i) : ""), \
    sprintf("< awk -F, 'NR > 1 && $%d == 1' %s | sort -t, -g -k%d,%d", 5 + c, file, 3 + c, 3 + c) using 3 + c:2 with lines \
      lw 2 lc rgb "#c04000" title (c == 0 ? "Pareto front" : "")
}
unset multiplot
