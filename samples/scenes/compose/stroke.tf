# The brightest tissue in FLAIR.
values normalised
colour  0.56  1.00 0.35 0.10
colour  0.90  1.00 0.85 0.30
opacity 0.56  0
opacity 0.66  0.12
opacity 1     0.60
