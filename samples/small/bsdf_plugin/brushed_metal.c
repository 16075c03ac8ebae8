/* A scattering routine for the board's DSP: metal with fine grooves, whose highlights are drawn out across them.
 *
 *   gicube-board --bsdf brushed_metal.so ...      the first such routine is number 8
 *
 * Parameters: the grooves' direction x y z (any length), the slopes' deviation across the grooves, the same along them,
 * and the share of light that is reflected. Without parameters: 1 0 0, 0.2, 0.02, 0.9.
 *
 * The facet that reflects has Gaussian slopes (Ward, Measuring and Modeling Anisotropic Reflection, SIGGRAPH 1992).
 */
#include <math.h>
#include <stdio.h>

#include "gicube/bsdf.h"

static const float kDefaults[6] = {1.0f, 0.0f, 0.0f, 0.2f, 0.02f, 0.9f};

static double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Takes the part along the unit vector `n` out of `a`, and makes a unit vector of the rest; returns 0 if there is
 * none. */
static int flatten(double* a, const double* n) {
  const double along = dot(a, n);
  for (int i = 0; i < 3; ++i) a[i] -= along * n[i];
  const double length = sqrt(dot(a, a));
  if (length < 1e-6) return 0;
  for (int i = 0; i < 3; ++i) a[i] /= length;
  return 1;
}

static void scatter(const gicube_bsdf_event* event, gicube_bsdf_answer* answer) {
  const float* p = event->parameter_count == 6 ? event->parameters : kDefaults;
  double n[3], grooves[3] = {p[0], p[1], p[2]}, across[3];
  const double facing = dot(event->normal, event->direction);
  for (int i = 0; i < 3; ++i) n[i] = facing > 0 ? -event->normal[i] : event->normal[i];
  if (dot(n, n) < 0.5) { /* no gradient: a surface that faces the ray */
    for (int i = 0; i < 3; ++i) n[i] = -event->direction[i];
  }
  if (!flatten(grooves, n)) { /* the grooves run into the surface: any direction on it will do */
    const int least = fabs(n[0]) < 0.6 ? 0 : 1;
    for (int i = 0; i < 3; ++i) grooves[i] = i == least;
    flatten(grooves, n);
  }
  across[0] = n[1] * grooves[2] - n[2] * grooves[1];
  across[1] = n[2] * grooves[0] - n[0] * grooves[2];
  across[2] = n[0] * grooves[1] - n[1] * grooves[0];

  const double radius = sqrt(-2 * log(1 - event->random[0])), angle = 6.283185307179586 * event->random[1];
  const double slope_across = p[3] * radius * cos(angle), slope_along = p[4] * radius * sin(angle);
  double facet[3];
  for (int i = 0; i < 3; ++i) facet[i] = n[i] + slope_across * across[i] + slope_along * grooves[i];
  const double twice = 2 * dot(event->direction, facet) / dot(facet, facet);
  for (int i = 0; i < 3; ++i) answer->direction[i] = event->direction[i] - twice * facet[i];
  const double out = dot(answer->direction, n);
  if (out < 0) { /* a steep facet would send the ray into the metal: its neighbour sends it out again */
    for (int i = 0; i < 3; ++i) answer->direction[i] -= 2 * out * n[i];
  }
  answer->passes = p[5];
}

static int check(const float* p, uint32_t count, char* text, size_t text_bytes) {
  if (count == 0) return 0;
  if (count != 6) {
    snprintf(text, text_bytes, "expected no parameters or 6, got %u", (unsigned)count);
  } else if (!(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > 0)) {
    snprintf(text, text_bytes, "grooves: expected a direction, got %g %g %g", p[0], p[1], p[2]);
  } else if (!(p[3] >= 0 && p[3] <= 2 && p[4] >= 0 && p[4] <= 2)) {
    snprintf(text, text_bytes, "slopes: expected 0..2, got %g and %g", p[3], p[4]);
  } else if (!(p[5] >= 0 && p[5] <= 1)) {
    snprintf(text, text_bytes, "reflected share: expected 0..1, got %g", p[5]);
  } else {
    return 0;
  }
  return 1;
}

const gicube_bsdf* gicube_bsdf_describe(void) {
  /* Cycles: estimated for a C6205, some 150 operations and seven iterative ones (root, logarithm, sines, divisions). */
  static const gicube_bsdf routine = {GICUBE_BSDF_ABI, sizeof(gicube_bsdf), "brushed metal", 320, 320, scatter, check};
  return &routine;
}
