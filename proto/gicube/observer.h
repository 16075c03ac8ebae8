/* What a board at fidelity=cycle tells of its parts: the records of `gicube-board --events`, and of an observer, a shared object that
 * `gicube-board --observer FILE.so` loads. Plain C, and nothing else is needed to build one:
 *
 *   cc -shared -fPIC -O2 -I proto my_observer.c -o my_observer.so
 *
 * docs/guide/observation.md has an example, the rules and the limits.
 */
#ifndef GICUBE_OBSERVER_H
#define GICUBE_OBSERVER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when a field changes its meaning or goes; a board loads only objects of its own version. */
#define GICUBE_OBSERVER_ABI 1u

/* NOLINTBEGIN(modernize-use-using, readability-identifier-naming): C, and its names */

/* Steps of a ray, and what `count` is then. */
enum {
  GICUBE_EVENT_MADE = 0,   /* by the DSP */
  GICUBE_EVENT_SENT,       /* to the ray bus; 1: it was sent before */
  GICUBE_EVENT_QUEUED,     /* into `queue` of `processor` */
  GICUBE_EVENT_OVERFLOWED, /* that queue has no slot: it goes back to the DSP */
  GICUBE_EVENT_ISSUED,     /* from `queue` to the pipeline */
  GICUBE_EVENT_SAMPLED,    /* its cache tags were checked; packets that are missing */
  GICUBE_EVENT_LEAPT,      /* over an empty block */
  GICUBE_EVENT_FILLED,     /* the missing packets have come; cycles for which the pipeline stood for them */
  GICUBE_EVENT_DEPOSITED,  /* its deposit waits to be written; carriers that it sends to other blocks */
  GICUBE_EVENT_LINKED,     /* on the links; the processor to which it goes */
  GICUBE_EVENT_ARRIVED,    /* from the links at `processor` */
  GICUBE_EVENT_GONE,       /* of a carrier: its deposit was written */
  GICUBE_EVENT_KEPT,       /* in the DSP's memory, since its queue overflowed */
  GICUBE_EVENT_SCATTERED,  /* by a routine of the DSP; the DSP cycles of the routine */
  GICUBE_EVENT_WAITS,      /* the DSP keeps it for the host */
  GICUBE_EVENT_TAKEN,      /* its source has what it gathered: a viewing ray is in the image */
  GICUBE_EVENT_COUNTERS,   /* of one processor, every so many cycles: see `values` */
  GICUBE_EVENT_KINDS
};

/* Read up to `size` bytes only: a later board may send more. */
typedef struct gicube_event {
  uint32_t size;       /* of this struct, bytes */
  uint16_t kind;       /* GICUBE_EVENT_... */
  int16_t processor;   /* -1: the DSP */
  uint64_t cycle;      /* of the core clock, since the machine was made */
  uint64_t ray;        /* of its command: a host's rays in their order, viewing rays as the DSP makes them */
  uint64_t count;      /* as the kind says */
  uint32_t run;        /* counts the runs of the machine: a command is at least one */
  uint32_t queue;      /* of the processor */
  uint32_t block[3];   /* in which the sample or leap was, else in which the ray is now */
  uint16_t u, v;       /* of the packet: of viewing rays the pixel, 12.4 */
  uint32_t is_carrier; /* 1: an irradiance carrier that the ray has sent */

  /* The ray after the event. */
  int32_t position[3]; /* 1/16384 voxel */
  uint32_t opacity;    /* 2^24 - 1 = one */
  uint16_t colour[3];  /* premultiplied, 4095 = one; of other rays than rendering rays what these words hold */

  /* The sample, of GICUBE_EVENT_SAMPLED unless a carrier's. */
  int16_t density;            /* 1/8 */
  int16_t gradient[3];        /* 16352 = one */
  uint16_t tag;               /* of the voxel */
  uint16_t sample_colour[3];  /* classified and shaded, 4095 = one */
  uint16_t end;               /* 0: the ray goes on; it has 1: left the volume, 2: become opaque, 3: been absorbed */
  int32_t sample_position[3]; /* 1/16384 voxel */
  double sample_opacity;      /* of the step that the sample stands for, 0..1 */

  /* Of GICUBE_EVENT_COUNTERS, since the machine was made: samples, cycles with a sample, rays that wait in queues now. */
  uint64_t values[3];
} gicube_event;

typedef struct gicube_observer {
  uint32_t abi;     /* GICUBE_OBSERVER_ABI */
  uint32_t size;    /* sizeof(gicube_observer) */
  const char* name; /* 1 to 64 printable characters, for messages */
  /* Gets events in their order, some at a time. */
  void (*take)(const gicube_event* events, size_t count);
  /* May be null. The board has ended, or no longer sends. */
  void (*end)(void);
} gicube_observer;

/* The object's one export. Called once; what it points to must live as long as the process. */
const gicube_observer* gicube_observer_describe(void);

/* NOLINTEND(modernize-use-using, readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
