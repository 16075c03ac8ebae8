# CT of people and animals, in Hounsfield units: the skin as a surface; cut planes show fat, muscle and bone by colours.
values hounsfield
colour  -400  0.90 0.67 0.55
colour  -100  0.96 0.80 0.62
colour  -20   0.93 0.66 0.53
colour  60    0.80 0.42 0.36
colour  180   0.88 0.60 0.48
colour  400   0.97 0.92 0.82
opacity -500  0
opacity -300  0.30
opacity -60   0.95
opacity 0     1
