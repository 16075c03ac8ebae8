# CT of people and animals, in Hounsfield units: bone alone, teeth whiter. Contrast agent shows as thin bone.
values hounsfield
colour  200   0.80 0.62 0.45
colour  520   0.93 0.84 0.68
colour  1200  0.98 0.95 0.88
colour  2200  1.00 1.00 1.00
opacity 180   0
opacity 320   0.15
opacity 520   0.85
opacity 800   1
