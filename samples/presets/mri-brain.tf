# Skull-stripped T1-weighted MRI: the cortex as a surface, white matter lighter.
values normalised
colour  0.15  0.60 0.36 0.32
colour  0.40  0.85 0.63 0.56
colour  0.58  0.93 0.78 0.70
colour  0.75  0.98 0.93 0.86
opacity 0.22  0
opacity 0.36  0.10
opacity 0.48  0.60
opacity 0.70  0.95
