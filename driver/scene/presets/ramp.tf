# Any scan: grey, the brighter the denser; the lower tenth of the range (air, noise) is clear.
values normalised
colour  0     0.35 0.38 0.42
colour  0.5   0.80 0.80 0.78
colour  1     1.00 1.00 1.00
opacity 0.10  0
opacity 0.50  0.08
opacity 1     0.50
