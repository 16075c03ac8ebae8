# Volumes with colours: theirs, as opaque as their sample: alpha, or how bright they are.
values normalised
colour  0   1 1 1
colour  1   1 1 1
opacity 0   0
opacity 1   1
