# Bone as thin glass.
values normalised
colour  0.30  0.90 0.88 0.80
colour  0.60  1.00 0.98 0.94
opacity 0.300 0
opacity 0.400 0.02
opacity 0.600 0.06
