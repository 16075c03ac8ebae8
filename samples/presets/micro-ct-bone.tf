# Micro-CT of a small animal: bone, from thin (warm) to thick (white).
values normalised
colour  0.10  0.78 0.56 0.42
colour  0.20  0.90 0.80 0.66
colour  0.35  0.97 0.93 0.85
colour  0.60  1.00 1.00 0.98
opacity 0.110 0
opacity 0.150 0.15
opacity 0.200 0.70
opacity 0.260 1
