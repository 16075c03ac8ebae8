# Skull-stripped T1-weighted MRI: the cortex as a surface, white matter lighter.
values normalised
colour  0.15  0.66 0.38 0.34
colour  0.36  0.93 0.70 0.62
colour  0.50  0.98 0.83 0.75
colour  0.75  1.00 0.96 0.90
opacity 0.22  0
opacity 0.34  0.10
opacity 0.46  0.70
opacity 0.60  1
