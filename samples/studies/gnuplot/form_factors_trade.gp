# Rays made by the host or by the DSP, over PCI and AGP 2x: error against the board's time and against the bus's, and the Pareto
# front of all of them (form_factors_front.csv, whose costs are of a pair).
set datafile separator ','
set logscale xy
set format y "10^{%T}"
set ylabel "error of a pair's transmittance (RMS)"
set grid
set key top right
row(bus, made, value) = strcol(1) eq bus && strcol(2) eq made ? value : NaN
do for [time in "board bus"] {
  column = time eq "board" ? 6 : 7
  set title sprintf("Random voxel pairs: error by %s time of a pair", time eq "board" ? "simulated" : "the bus's")
  set xlabel "simulated microseconds a pair"
  set terminal svg size 800,480 background 'white'
  set output sprintf("form_factors_trade_%s.svg", time)
  plot for [bus in "pci33 agp2x"] for [made in "host board"] 'form_factors_trade.csv' \
    using (row(bus, made, column(column) / column(4) * 1000)):5 with linespoints lw 2 \
    title sprintf("%s, rays made by the %s", bus, made eq "host" ? "host" : "DSP"), \
    sprintf("< awk -F, 'NR > 1 && $%d == 1' form_factors_front.csv | sort -t, -g -k%d,%d", column - 1, column - 3, column - 3) \
    using (column(column - 3) * 1000):2 with lines lw 4 dt 3 lc rgb "#c04000" title "Pareto front"
}
