# Industrial CT of a light casting with dense inserts: the casting translucent and cool, the inserts opaque and warm.
values robust
colour  0.25  0.55 0.66 0.78
colour  0.62  0.78 0.86 0.95
colour  0.72  0.95 0.55 0.20
colour  0.85  1.00 0.78 0.35
opacity 0.25  0
opacity 0.40  0.035
opacity 0.55  0.050
opacity 0.68  0.050
opacity 0.74  0.70
opacity 0.82  1
