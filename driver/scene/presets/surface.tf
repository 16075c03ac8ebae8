# One material over a background, of any scan: an opaque surface half way between them.
values robust
colour  0.30  0.55 0.62 0.70
colour  0.70  0.82 0.86 0.90
colour  1.00  0.97 0.97 0.96
opacity 0.35  0
opacity 0.50  0.60
opacity 0.65  1
