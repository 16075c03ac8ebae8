# Micro-CT of a small animal: bone, from thin (warm) to thick (white).
values robust
colour  0.13  0.80 0.60 0.46
colour  0.27  0.92 0.83 0.70
colour  0.54  0.97 0.94 0.87
colour  1.00  1.00 1.00 0.98
opacity 0.12  0
opacity 0.18  0.20
opacity 0.24  0.90
opacity 0.27  1
