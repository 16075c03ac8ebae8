# A brain in T1, seen through.
values normalised
colour  0.15  0.60 0.45 0.50
colour  0.50  0.85 0.75 0.80
opacity 0.22  0
opacity 0.34  0.02
opacity 0.46  0.05
opacity 1     0.07
