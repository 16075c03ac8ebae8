# A hierarchy of links against a link for each pair of elements.
set datafile separator ','
set title "Radiosity: error by links"
set xlabel "links"
set ylabel "error of the incident light"
set logscale xy
set format x "10^{%T}"
set grid
set key top right
do for [format in "svg png"] {
  if (format eq "svg") { set terminal svg size 800,480 background 'white' } else { set terminal pngcairo size 800,480 }
  set output 'form_factors_hierarchy.' . format
  plot 'form_factors_hierarchy.csv' using (strcol(1) eq "1" ? $5 : NaN):3 with linespoints lw 2 title "hierarchy", \
    '' using (strcol(1) eq "0" ? $5 : NaN):3 with points pt 7 ps 1.5 title "full matrix"
}
