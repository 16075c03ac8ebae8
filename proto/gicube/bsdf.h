/* Interface of scattering routines for the board's DSP, as shared objects that `gicube-board --bsdf FILE.so` loads. It
 * is plain C, and only this file is needed to build one:
 *
 *   cc -shared -fPIC -O2 -I proto my_bsdf.c -o my_bsdf.so -lm
 *   gicube-board --bsdf ./my_bsdf.so ...     (the first FILE.so is routine 8, the next 9, and so on)
 *
 * The object exports one function, gicube_bsdf_describe(), which returns its description. Rays in a material of kind
 * "trap" with the routine's number call it. docs/guide/scattering_routines.md has an example, the rules and the limits.
 *
 * Units: directions are unit vectors in physical space (axes parallel to the voxel axes), positions are in voxels.
 * */
#ifndef GICUBE_BSDF_H
#define GICUBE_BSDF_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Incremented when a field is removed or changes its meaning. A board loads only objects of its own version. */
#define GICUBE_BSDF_ABI 1u

/* NOLINTBEGIN(modernize-use-using, readability-identifier-naming): C names */

/* A ray that waits for the routine. Later boards may append fields: read at most `size` bytes. */
typedef struct gicube_bsdf_event {
  uint32_t size;            /* size of this struct, bytes */
  uint32_t tag;             /* tag of the voxel, 0..3 */
  double position[3];       /* voxels */
  double direction[3];      /* direction of travel */
  double normal[3];         /* against the density's gradient: out of dense material; zero without a gradient */
  double opacity;           /* opacity of one voxel length of the material there, 0..1 */
  double density;           /* 0..4095 */
  double random[4];         /* uniform in [0, 1), drawn for this event: the only randomness that a routine may use */
  uint32_t lighting;        /* 1: a lighting ray, which carries energy from a light; 0: a rendering ray, from the eye */
  uint32_t generation;      /* number of earlier scatterings of the ray, at most 15 */
  const float* parameters;  /* the material's parameters */
  uint32_t parameter_count; /* 0..32 */
  uint32_t reserved;        /* always 0 */
} gicube_bsdf_event;

/* The result. Before the call, the board sets `passes` to 1, `cycles` to the declared cycles and `direction` to
 * zero. */
typedef struct gicube_bsdf_answer {
  double direction[3]; /* direction in which the ray continues; its length is 1e-6 to 1e6 */
  double passes;       /* the share of the ray's energy (or of what it can still gather) that continues, 0..1 */
  uint32_t cycles;     /* DSP cycles of this call: 1 to the declared budget */
  uint32_t reserved;   /* must be 0 */
} gicube_bsdf_answer;

typedef struct gicube_bsdf {
  uint32_t abi;          /* GICUBE_BSDF_ABI */
  uint32_t size;         /* sizeof(gicube_bsdf) */
  const char* name;      /* 1 to 64 printable characters, for messages */
  uint32_t cycles;       /* DSP cycles per call, 1 to cycle_budget; the built-in routines declare 200 */
  uint32_t cycle_budget; /* the maximum that a call may report */

  /* Must be a pure function: the same event gets the same answer, regardless of earlier calls and of the process.
   * Concurrent calls run in copies of the process that loaded the object. */
  void (*scatter)(const gicube_bsdf_event* event, gicube_bsdf_answer* answer);

  /* May be null. Returns 0 if the parameters are valid; otherwise writes the reason, at most text_bytes bytes with the
   * terminating zero. Called before each command whose rays can reach the material. */
  int (*check)(const float* parameters, uint32_t parameter_count, char* text, size_t text_bytes);
} gicube_bsdf;

/* The only exported function. It is called once; the returned data must remain valid while the process runs. */
const gicube_bsdf* gicube_bsdf_describe(void);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-use-using, readability-identifier-naming) */

#endif
