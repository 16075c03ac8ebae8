# Values on both sides of 0, as of a field or a difference: below 0 blue, above 0 orange; near 0 clear.
values robust
colour  0     0.00 0.35 0.75
colour  0.40  0.55 0.80 0.95
colour  0.50  0.90 0.90 0.90
colour  0.60  0.98 0.80 0.50
colour  1     0.85 0.35 0.00
opacity 0     0.50
opacity 0.25  0.12
opacity 0.42  0
opacity 0.58  0
opacity 0.75  0.12
opacity 1     0.50
