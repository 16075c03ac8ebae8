# CT as for ct-bone: skin and soft tissue as a warm translucent layer, bone behind it.
values normalised
colour  0.05  0.92 0.60 0.46
colour  0.24  0.96 0.68 0.54
colour  0.29  0.85 0.45 0.35
colour  0.34  0.94 0.86 0.72
colour  0.60  1.00 0.98 0.93
opacity 0.070 0
opacity 0.120 0.110
opacity 0.200 0.110
opacity 0.245 0.004
opacity 0.290 0.008
opacity 0.340 0.25
opacity 0.420 1
