# Micro-CT of a small animal: bone, from thin (warm) to thick (white).
values normalised
colour  0.08  0.80 0.60 0.46
colour  0.16  0.92 0.83 0.70
colour  0.32  0.97 0.94 0.87
colour  0.60  1.00 1.00 0.98
opacity 0.070 0
opacity 0.105 0.20
opacity 0.140 0.90
opacity 0.160 1
