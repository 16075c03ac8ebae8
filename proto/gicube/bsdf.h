/* Scattering routines of a board's DSP as shared objects: what `gicube-board --bsdf FILE.so` loads. Plain C, and nothing
 * else is needed to build one:
 *
 *   cc -shared -fPIC -O2 -I proto my_bsdf.c -o my_bsdf.so -lm
 *   gicube-board --bsdf ./my_bsdf.so ...     (the first FILE.so is routine 8, the next 9, and so on)
 *
 * The object exports one function, gicube_bsdf_describe(), which returns its description. A material of kind "trap" with the
 * routine's number sends its rays there. docs/guide/scattering_routines.md has an example, the rules and the limits.
 *
 * Units: directions are unit vectors in physical space (axes parallel to the voxel axes), positions are in voxels.
 */
#ifndef GICUBE_BSDF_H
#define GICUBE_BSDF_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when a field changes its meaning or goes; a board loads only objects of its own version. */
#define GICUBE_BSDF_ABI 1u

/* NOLINTBEGIN(modernize-use-using, readability-identifier-naming): C, and its names */

/* A ray that waits for the routine. Read up to `size` bytes only: a later board may send more. */
typedef struct gicube_bsdf_event {
  uint32_t size;            /* of this struct, bytes */
  uint32_t tag;             /* of the voxel, 0..3 */
  double position[3];       /* voxels */
  double direction[3];      /* in which the ray travels */
  double normal[3];         /* against the density's gradient: out of what is dense; zero where there is no gradient */
  double opacity;           /* of one voxel length of the material there, 0..1 */
  double density;           /* 0..4095 */
  double random[4];         /* even in [0, 1), of this event alone: the only randomness that a routine may use */
  uint32_t lighting;        /* 1: a lighting ray, which carries energy from a light; 0: a rendering ray, from the eye */
  uint32_t generation;      /* how often the ray was scattered before, at most 15 */
  const float* parameters;  /* the material's */
  uint32_t parameter_count; /* 0..32 */
  uint32_t reserved;        /* 0 */
} gicube_bsdf_event;

/* What becomes of it. The board has set `passes` to 1, `cycles` to the declared cycles and `direction` to zero. */
typedef struct gicube_bsdf_answer {
  double direction[3]; /* in which the ray goes on; of a length from 1e-6 to 1e6 */
  double passes;       /* the share of the ray's energy (or of what it can still gather) that goes on, 0..1 */
  uint32_t cycles;     /* DSP cycles that this call took: 1 to the declared budget */
  uint32_t reserved;   /* leave it 0 */
} gicube_bsdf_answer;

typedef struct gicube_bsdf {
  uint32_t abi;          /* GICUBE_BSDF_ABI */
  uint32_t size;         /* sizeof(gicube_bsdf) */
  const char* name;      /* 1 to 64 printable characters, for messages */
  uint32_t cycles;       /* DSP cycles of a call, 1 to cycle_budget; 200 is what the built-in routines declare */
  uint32_t cycle_budget; /* the most that a call may report */

  /* A pure function: the same event gets the same answer, whatever was called before and in whatever process: calls at the
   * same time are made in copies of the process that loaded the object. */
  void (*scatter)(const gicube_bsdf_event* event, gicube_bsdf_answer* answer);

  /* May be null. Returns 0 if the routine can work with these parameters; else writes why not, as text of at most
   * text_bytes bytes with the closing zero. Asked before each command that can meet the material. */
  int (*check)(const float* parameters, uint32_t parameter_count, char* text, size_t text_bytes);
} gicube_bsdf;

/* The object's one export. Called once; what it points to must live as long as the process. */
const gicube_bsdf* gicube_bsdf_describe(void);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(modernize-use-using, readability-identifier-naming) */

#endif
