# CT whose range runs from air over some 4000 Hounsfield units, 0.25 being water: bone alone, teeth whiter.
values normalised
colour  0.30  0.80 0.62 0.45
colour  0.38  0.93 0.84 0.68
colour  0.55  0.98 0.95 0.88
colour  0.80  1.00 1.00 1.00
opacity 0.300 0
opacity 0.345 0.15
opacity 0.390 0.85
opacity 0.450 1
