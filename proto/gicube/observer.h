/* Event records of a board at fidelity=cycle. `gicube-board --events` writes them; an observer receives them. An
 * observer is a shared object that `gicube-board --observer FILE.so` loads. The interface is plain C, and only this
 * file is needed to build one:
 *
 *   cc -shared -fPIC -O2 -I proto my_observer.c -o my_observer.so
 *
 * docs/guide/observation.md has an example, the rules and the limits.
 * */
#ifndef GICUBE_OBSERVER_H
#define GICUBE_OBSERVER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Incremented when a field is removed or changes its meaning. A board loads only objects of its own version. */
#define GICUBE_OBSERVER_ABI 1u

/* NOLINTBEGIN(modernize-use-using, readability-identifier-naming): C names */

/* Events of a ray; after a semicolon, the meaning of `count`. */
enum {
  GICUBE_EVENT_MADE = 0,   /* created by the DSP */
  GICUBE_EVENT_SENT,       /* sent to the ray bus; 1: it was sent before */
  GICUBE_EVENT_QUEUED,     /* entered `queue` of `processor` */
  GICUBE_EVENT_OVERFLOWED, /* that queue is full, so the ray returns to the DSP */
  GICUBE_EVENT_ISSUED,     /* issued from `queue` to the pipeline */
  GICUBE_EVENT_SAMPLED,    /* its cache tags were checked; the number of missing packets */
  GICUBE_EVENT_LEAPT,      /* it skipped an empty block */
  GICUBE_EVENT_FILLED,     /* the missing packets have arrived; the cycles for which the pipeline stalled */
  GICUBE_EVENT_DEPOSITED,  /* its deposit is queued for writing; the number of carriers sent to other blocks */
  GICUBE_EVENT_LINKED,     /* it entered the links; the destination processor */
  GICUBE_EVENT_ARRIVED,    /* it arrived from the links at `processor` */
  GICUBE_EVENT_GONE,       /* carrier: its deposit was written */
  GICUBE_EVENT_KEPT,       /* stored in the DSP's memory after its queue overflowed */
  GICUBE_EVENT_SCATTERED,  /* scattered by a routine of the DSP; the DSP cycles of the routine */
  GICUBE_EVENT_WAITS,      /* the DSP keeps it until the host answers */
  GICUBE_EVENT_TAKEN,      /* its source has taken the result: a viewing ray is in the image */
  GICUBE_EVENT_COUNTERS,   /* counters of one processor, at a fixed interval of cycles: see `values` */
  GICUBE_EVENT_KINDS
};

/* Later boards may append fields: read at most `size` bytes. */
typedef struct gicube_event {
  uint32_t size;       /* size of this struct, bytes */
  uint16_t kind;       /* GICUBE_EVENT_... */
  int16_t processor;   /* -1: the DSP */
  uint64_t cycle;      /* core clock, since the machine was built */
  uint64_t ray;        /* number in its command: host rays in their order, viewing rays in the DSP's order */
  uint64_t count;      /* depends on `kind` */
  uint32_t run;        /* number of the machine's run; a command has at least one */
  uint32_t queue;      /* number of the processor's queue */
  uint32_t block[3];   /* block of the sample or skip, otherwise the ray's current block */
  uint16_t u, v;       /* fields of the packet: for viewing rays the pixel, 12.4 */
  uint32_t is_carrier; /* 1: an irradiance carrier that the ray has sent */

  /* State of the ray after the event. */
  int32_t position[3]; /* 1/16384 voxel */
  uint32_t opacity;    /* 2^24 - 1 = one */
  uint16_t colour[3];  /* premultiplied, 4095 = one; for other than rendering rays the raw words */

  /* The sample: only for GICUBE_EVENT_SAMPLED of a ray that is not a carrier. */
  int16_t density;            /* 1/8 */
  int16_t gradient[3];        /* 16352 = one */
  uint16_t tag;               /* tag of the voxel */
  uint16_t sample_colour[3];  /* classified and shaded, 4095 = one */
  uint16_t end;               /* 0: the ray continues; 1: it has left the volume; 2: become opaque; 3: been absorbed */
  int32_t sample_position[3]; /* 1/16384 voxel */
  double sample_opacity;      /* opacity of the sample's step, 0..1 */

  /* GICUBE_EVENT_COUNTERS: samples and cycles with a sample since the machine was built; rays in queues. */
  uint64_t values[3];
} gicube_event;

typedef struct gicube_observer {
  uint32_t abi;     /* GICUBE_OBSERVER_ABI */
  uint32_t size;    /* sizeof(gicube_observer) */
  const char* name; /* 1 to 64 printable characters, for messages */
  /* Receives events in batches, in their order. */
  void (*take)(const gicube_event* events, size_t count);
  /* May be null. Called when the board ends or stops sending. */
  void (*end)(void);
} gicube_observer;

/* The only exported function. It is called once; the returned data must remain valid while the process runs. */
const gicube_observer* gicube_observer_describe(void);

/* NOLINTEND(modernize-use-using, readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
