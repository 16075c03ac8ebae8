# Micro-CT of a small animal: bone, from thin (warm) to thick (white), in a trace of soft tissue.
values normalised
colour  0.10  0.70 0.42 0.32
colour  0.20  0.86 0.72 0.55
colour  0.35  0.95 0.90 0.80
colour  0.60  1.00 1.00 0.98
opacity 0.140 0
opacity 0.200 0.10
opacity 0.280 0.60
opacity 0.400 1
