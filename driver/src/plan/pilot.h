// Pilot pictures, and what can be said from two of them about the error of a whole picture.
#pragma once

#include "gicube/board.h"

namespace gicube {

struct Pilot {
  Image image;
  double samples = 0;
  Picoseconds time = 0;  // simulated, rendering and framebuffer transfer
};

// `view` with about edge^2 pixels of the same shape, one ray each; never more than it has.
View pilot_view(View view, int edge);
// Renders it; the board's tables for this camera direction should be on the board, else their transfer counts.
Pilot take_pilot(Board& board, const View& view);

// Relative root mean square errors, as plan.h defines them.
struct PilotError {
  double estimate = 0;
  double bound = 0;  // infinite if the best pilot shows nothing, and so nothing is known
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

// A picture of r rays takes A + B sqrt(r) + C r: its command, what lies on the borders of what neighbouring rays share,
// and the rays. From a tiny picture, a small and a large one; without a large one (no rays) from the small one alone, B
// = 0. Rays that lie closer together than the pilots' share still more.
double extrapolated_time(const TimePoint& tiny, const TimePoint& small, const TimePoint& large, double rays);

}  // namespace gicube
