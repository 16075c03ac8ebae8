# scaling_*.csv: what a run costs the computer that emulates the board, by the size of what is asked for, with the exponent of a
# power law fitted to each level's points.
set datafile separator ','
set logscale xy
set format y "%g"
set grid
set key top left
set fit quiet
set fit logfile '/dev/null'
column_of(file, name) = int(system(sprintf("head -1 %s | tr ',' '\\n' | grep -nx '%s' | cut -d: -f1", file, name)))
colour(level) = level eq "cycle" ? "#404040" : level eq "functional" ? "#0060ad" : "#c04000"
number(text) = real(text[1:strstrt(text . "x", "x") - 1])  # of a size WxH the width
what = "volume image processors rays"
axis = "volume-size size asic.processors light-rays"
name = "'edge of the volume, voxels' 'edge of the image, pixels' 'processors' 'lighting rays a voxel of the faces'"
do for [i = 1:4] {
  file = sprintf("scaling_%s.csv", word(what, i))
  at = column_of(file, word(axis, i))
  f = column_of(file, "fidelity")
  m = column_of(file, "/host/board_peak_mib")
  # Points of one level: gnuplot's fit wants them by themselves.
  of(level) = sprintf("< awk -F, 'NR > 1 && $%d == \"%s\"' %s", f, level, file)
  a_seconds = ""; a_memory = ""
  do for [level in "functional approximate cycle"] {
    line(t) = a + b * t
    a = 1; b = 1
    fit line(x) of(level) using (log(number(strcol(at)))):(log($1)) via a, b
    a_seconds = a_seconds . sprintf(" %.2f", b)
    a = 1; b = 1
    fit line(x) of(level) using (log(number(strcol(at)))):(log(column(m))) via a, b
    a_memory = a_memory . sprintf(" %.2f", b)
  }
  set terminal svg size 1100,460 background 'white'
  set output sprintf("scaling_%s.svg", word(what, i))
  set xlabel word(name, i)
  set multiplot layout 1, 2
  set title "host seconds (exponents fitted)"
  set ylabel "s"
  plot for [k = 1:3] of(word("functional approximate cycle", k)) using (number(strcol(at))):1 with linespoints pt 7 \
    lc rgb colour(word("functional approximate cycle", k)) \
    title sprintf("%s: %s", word("functional approximate cycle", k), word(a_seconds, k))
  set title "peak memory of the board's process (exponents fitted)"
  set ylabel "MiB"
  plot for [k = 1:3] of(word("functional approximate cycle", k)) using (number(strcol(at))):m with linespoints pt 7 \
    lc rgb colour(word("functional approximate cycle", k)) \
    title sprintf("%s: %s", word("functional approximate cycle", k), word(a_memory, k))
  unset multiplot
}
