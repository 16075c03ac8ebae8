// Pilot pictures, and estimates of a whole picture's error from two of them.
#pragma once

#include "gicube/board.h"

namespace gicube {

struct Pilot {
  Image image;
  double samples = 0;
  Picoseconds time = 0;  // simulated time of rendering and transfer
};

// `view` with about edge^2 pixels, at most its own, in the same aspect ratio, one ray per pixel.
View pilot_view(View view, int edge);
// Renders a pilot. The tables for its camera should be on the board already, otherwise their transfer is counted.
Pilot take_pilot(Board& board, const View& view);

// Relative root mean square errors, as plan.h defines them.
struct PilotError {
  double estimate = 0;
  double bound = 0;  // infinite if the best pilot shows nothing
};
// Compares pilots of equal size. `channel` 0, 1, 2: red, green or blue alone and a third of alpha, so that the sums of
// the three are those of the picture that is composed of them.
PilotError pilot_error(const Image& pilot, const Image& best, int channel = -1);

// Estimates, from two pilots with independent random choices, the distance of either from the limit of infinitely many
// rays.
PilotError noise_of(const Image& a, const Image& b, int channel);
// Estimates, from such pairs of two settings, their distance without the noise: the noises of a product's factors are
// independent. The bound has two standard errors, the limit of what the pairs can show.
PilotError bias_of(const Image& a, const Image& b, const Image& best_a, const Image& best_b, int channel);

struct TimePoint {
  double rays = 0;
  double time = 0;
};

// The time of a picture of r rays is modelled as A + B sqrt(r) + C r: the command, memory accesses that neighbouring
// rays share, and the rays. Fitted to a tiny, a small and a large picture; if the large one has 0 rays, B = 0. An upper
// bound, because closer rays share more.
double extrapolated_time(const TimePoint& tiny, const TimePoint& small, const TimePoint& large, double rays);

}  // namespace gicube
