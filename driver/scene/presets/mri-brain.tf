# T1-weighted MRI or FLAIR of a brain or a head: the cortex (or the skin) as a surface, white matter lighter.
values robust
colour  0.17  0.66 0.38 0.34
colour  0.42  0.93 0.70 0.62
colour  0.58  0.98 0.83 0.75
colour  0.87  1.00 0.96 0.90
opacity 0.25  0
opacity 0.39  0.10
opacity 0.53  0.70
opacity 0.70  1
