# A hierarchy of links against a link for each pair of elements.
set datafile separator ','
set title "Radiosity: error by links"
set xlabel "links"
set ylabel "error of the incident light"
set logscale xy
set format x "10^{%T}"
set grid
set key top right
set terminal svg size 800,480 background 'white'
set output 'form_factors_hierarchy.svg'
plot 'form_factors_hierarchy.csv' using (strcol(1) eq "1" ? $5 : NaN):3 with linespoints lw 2 title "hierarchy", \
  '' using (strcol(1) eq "0" ? $5 : NaN):3 with points pt 7 ps 1.5 title "full matrix"
