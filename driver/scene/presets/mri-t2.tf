# T2-weighted MRI: tissue as a warm surface, fluid (ventricles, cysts, oedema) blue and opaque.
values robust
colour  0.10  0.66 0.38 0.34
colour  0.27  0.93 0.72 0.64
colour  0.40  0.98 0.88 0.82
colour  0.55  0.62 0.82 1.00
colour  0.85  0.30 0.62 0.98
opacity 0.13  0
opacity 0.20  0.10
opacity 0.27  0.60
opacity 0.40  1
