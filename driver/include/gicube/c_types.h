/* Records of the C ABI (gicube/c_api.h). Units and meanings are those of the C++ headers named with each.
 *
 * A record that begins with `size` may grow at its end in later versions. Its gicube_..._init() sets all defaults and
 * the size that the caller was compiled with; the library reads and writes no more than that. Fields that an older
 * caller does not have take their defaults, and fields that an older library does not have must be zero. All other
 * records stand in arrays and never change. Truth values are 0 or 1. */
#ifndef GICUBE_C_TYPES_H
#define GICUBE_C_TYPES_H

#include <stddef.h>
#include <stdint.h>

/* NOLINTBEGIN(modernize-use-using, readability-identifier-naming): C, and its names */

#ifdef __cplusplus
extern "C" {
#endif

/* The result of a call. The numbers do not change. */
typedef int32_t gicube_status;
enum {
  GICUBE_OK = 0,
  GICUBE_BAD_ARGUMENT = 1,      /* a value of the caller's is wrong; the board is untouched */
  GICUBE_OPEN_FAILED = 2,       /* no board there */
  GICUBE_BOARD_BUSY = 3,        /* it has another owner */
  GICUBE_VERSION_MISMATCH = 4,  /* driver and board speak different major versions */
  GICUBE_REJECTED = 5,          /* the board is not in a state for it, which stays as it is */
  GICUBE_SCATTERING_FAILED = 6, /* a scattering routine gave an answer that no ray can follow */
  GICUBE_UNSUPPORTED = 7,       /* this board or fidelity level can't do it */
  GICUBE_DEVICE_LOST = 8,       /* the link to the board is gone: gicube_last_loss() says why */
  GICUBE_TIMED_OUT = 9,         /* no answer within the wall-clock watchdog; as after GICUBE_DEVICE_LOST */
  GICUBE_DEADLINE_PASSED = 10,  /* a simulated time has come first; the board works on */
  GICUBE_WOULD_BLOCK = 11,      /* as many rays are under way as may be; nothing was sent */
  GICUBE_MEMORY_FAULT = 12, /* the board's RDRAM reported an error; nothing has changed: the call may be made again */
  GICUBE_STOPPED = 13,      /* a callback of the caller's returned nonzero, or gicube_pending_cancel() ended the call */
  GICUBE_NO_MEMORY = 14,    /* of this process */
  GICUBE_INTERNAL = 15      /* a fault of the driver itself */
};

/* Receives a sentence about each event that no call reports: a session that was lost and resumed, and why. Called on
 * the thread of the call that resumed it; it may only call gicube_get_info() of its board. */
typedef void (*gicube_log)(void* user, const char* sentence);

/* gicube/board.h: OpenOptions */
enum { GICUBE_BACK_PRESSURE_WAIT = 0, GICUBE_BACK_PRESSURE_FAIL = 1 };
typedef struct gicube_open_options {
  uint32_t size;
  int32_t back_pressure;
  uint64_t watchdog_ms;       /* wall clock; 0 = no limit */
  uint64_t max_rays;          /* that may be under way */
  int32_t keep_volume;        /* so that gicube_reopen() can load it again */
  int32_t reopen_attempts;    /* how often in a row a call resumes a session that lost its connection */
  int32_t force;              /* takes the board from its owner */
  int32_t reserved;           /* 0 */
  uint64_t wait_for_board_ms; /* in line while the board has an owner */
  const char* capture;        /* NULL, or the file that the session's frames are written to (docs/guide/capture.md) */
  const char* token_file;     /* NULL, or a file with the access token, for tcp:, tls:, pci: */
  const char* ca_file;  /* NULL, or a file with the certificates of those who may have signed the board's, for tls: */
  int32_t go_on;        /* the board continues from the checkpoint of its process, instead of being reset */
  int32_t reserved_too; /* 0 */
  uint64_t
      max_waiting_rays; /* for blocks of a volume: on the card, and as many in the host's memory; others in a file */
  gicube_log log;       /* NULL: none */
  void* log_user;       /* its first argument */
} gicube_open_options;

/* gicube/board.h: Reopened */
typedef struct gicube_reopened {
  int32_t resumed; /* the same session continues: nothing was lost */
  int32_t volume;  /* there is a volume on the board */
} gicube_reopened;

/* gicube/enumerate.h: FoundBoard. The texts live as long as the list that they are from. */
typedef struct gicube_found_board {
  uint32_t size;
  int32_t in_use;      /* a session owns it */
  uint32_t process;    /* the id of its gicube-board; 0: a PCI function, which has no version and no owner here */
  uint32_t reserved;   /* 0 */
  const char* uri;     /* for gicube_open() */
  const char* product; /* what it calls itself */
  const char* version; /* of its program */
  const char* owner;   /* which, and since when; empty: none */
} gicube_found_board;

/* gicube/error.h: why GICUBE_DEVICE_LOST */
enum {
  GICUBE_LOSS_NONE = -1,     /* the last failure was another */
  GICUBE_LOSS_CLOSED = 0,    /* the board's process ended, or the connection did */
  GICUBE_LOSS_CORRUPTED = 1, /* a frame was damaged, or one is missing */
  GICUBE_LOSS_TIMED_OUT = 2,
  GICUBE_LOSS_TAKEN_OVER = 3, /* another client took the board by force */
  GICUBE_LOSS_ENDED = 4       /* the board ended the session, or the driver did, whose capture could not be written */
};

/* gicube/board.h: BoardInfo */
enum { GICUBE_VOXEL_DENSITY = 0, GICUBE_VOXEL_RGB = 1, GICUBE_VOXEL_RGBA = 2 };
enum { GICUBE_FIDELITY_FUNCTIONAL = 0, GICUBE_FIDELITY_APPROXIMATE = 1, GICUBE_FIDELITY_CYCLE = 2 };
typedef struct gicube_board_info {
  uint32_t size;
  int32_t protocol_major;
  int32_t protocol_minor;
  int32_t fidelity;
  int32_t processors;
  int32_t block_voxels;
  int32_t max_volume_voxels;
  int32_t queue_rays;
  uint64_t config_hash;
  uint32_t core_khz;
  uint16_t vendor_id;
  uint16_t device_id;
  int32_t wide;
  int32_t agp;
  int32_t host_rays;
  int32_t voxel_format;     /* GICUBE_VOXEL_..., what the card stores of a voxel */
  int32_t irradiance_words; /* of a voxel: 1, or 3 for red, green and blue */
} gicube_board_info;

/* gicube/volume.h: VolumeView; everything pointed to must live until the call returns */
enum {
  GICUBE_SAMPLE_UINT8 = 0,
  GICUBE_SAMPLE_UINT12 = 1,
  GICUBE_SAMPLE_UINT16 = 2,
  GICUBE_SAMPLE_INT16 = 3,
  GICUBE_SAMPLE_FLOAT32 = 4
};
typedef struct gicube_volume {
  uint32_t size;
  int32_t type;           /* of the samples */
  int32_t dims[3];        /* voxels; x is the fastest axis */
  int32_t has_range;      /* 1: low and high are given */
  const void* samples;    /* dims[0] * dims[1] * dims[2] of them */
  size_t sample_bytes;    /* of all samples */
  double spacing[3];      /* physical voxel edge */
  double low, high;       /* the range of values */
  const float* gradients; /* NULL, or three for each voxel */
  size_t gradient_count;  /* floats */
  const uint8_t* tags;    /* NULL, or one for each voxel, 0..3 */
  size_t tag_count;
  int32_t find_gradients; /* 0, without gradients: none are computed, and nothing of the volume is shaded */
  int32_t reserved;       /* 0 */
  const uint8_t* colours; /* NULL, or red, green and blue of each voxel, 255 = 1: for cards whose voxels have colours */
  size_t colour_bytes;
} gicube_volume;

/* A box of voxels, gicube/volume.h: VoxelBox */
typedef struct gicube_box {
  int32_t low[3];
  int32_t size[3];
} gicube_box;

/* gicube/transfer_function.h: values rise, but two points may share one: a step */
typedef struct gicube_colour_point {
  double value;
  double colour[3]; /* red green blue, 0..1 */
} gicube_colour_point;
typedef struct gicube_opacity_point {
  double value;
  double opacity; /* 0..1, of one voxel length */
} gicube_opacity_point;

/* gicube/shading.h: Shading */
typedef struct gicube_shading {
  uint32_t size;
  uint32_t reserved; /* 0 */
  double ambient, diffuse, specular, shininess;
  double light[3]; /* towards the light; zero = at the eye */
} gicube_shading;

/* gicube/material.h: Material */
enum {
  GICUBE_BSDF_NONE = 0,
  GICUBE_BSDF_SPECULAR = 1,
  GICUBE_BSDF_DULL_REFLECTION = 2,
  GICUBE_BSDF_DULL_SCATTERING = 3,
  GICUBE_BSDF_ISOTROPIC = 4,
  GICUBE_BSDF_DIFFUSE = 5,
  GICUBE_BSDF_TRAP = 6
};
enum { GICUBE_HOST_ROUTINE = 255 }; /* gicube_set_scattering_routine() */
typedef struct gicube_material {
  uint32_t size;
  int32_t bsdf;
  double scattering;
  double gloss;
  int32_t seen_through_scattering;
  int32_t routine;
  int32_t surface;
  uint32_t parameter_count; /* at most 32 */
  const float* parameters;
  double scattering_colour[3];
} gicube_material;

/* gicube/scattering.h: ScatterEvent, as the library fills it */
typedef struct gicube_scatter_event {
  uint32_t size; /* that the library knows: read no further */
  int32_t tag;
  double position[3];
  double direction[3];
  double normal[3];
  double opacity;
  double density;
  double random[4];
  int32_t lighting;
  int32_t generation;
  const float* parameters;
  size_t parameter_count;
} gicube_scatter_event;
typedef struct gicube_scatter_answer {
  double direction[3]; /* (0, 0, 0) at first */
  double passes;       /* 1 at first */
} gicube_scatter_answer;

/* gicube/illumination.h: Light. Which fields count depends on the kind */
enum { GICUBE_LIGHT_POINT = 0, GICUBE_LIGHT_DIRECTIONAL = 1, GICUBE_LIGHT_RECTANGLE = 2, GICUBE_LIGHT_SPHERE = 3 };
typedef struct gicube_light {
  int32_t kind;
  int32_t reserved;   /* 0 */
  double position[3]; /* point: its place; rectangle: corner; sphere: centre; directional: towards the light */
  double edge_u[3];   /* rectangle */
  double edge_v[3];   /* rectangle */
  double radius;      /* sphere */
  double power;       /* directional: irradiance */
} gicube_light;

/* gicube/illumination.h: Illumination, LightingReport */
enum { GICUBE_ALBEDO_LOW = 0, GICUBE_ALBEDO_HIGH = 1 };
enum { GICUBE_RULES_AS_PRINTED = 0, GICUBE_RULES_CONSERVING = 1 };
typedef struct gicube_illumination {
  uint32_t size;
  int32_t albedo;
  int32_t rules;
  int32_t rays_per_face_voxel;
  double step;
  int32_t jitter;
  int32_t leap;
  int32_t lifetime;
  uint32_t seed;
  const double* light_colours; /* red, green and blue of each light; NULL: all are white */
  size_t light_colour_count;   /* of lights: 0, or all of them */
} gicube_illumination;
typedef struct gicube_light_energy {
  double emitted, deposited, escaped, scattered_away, given_up, clipped;
} gicube_light_energy;
typedef struct gicube_lighting_report {
  uint32_t size;
  uint32_t warnings; /* how many: gicube_lighting_warning() */
  uint64_t rays;
  double emitted, deposited, escaped, scattered_away, given_up, clipped;
  double unit;
  double escaped_by_face[6];      /* of `escaped`: x = 0, x = size - 1, y = 0, ... */
  gicube_light_energy colours[3]; /* red, green, blue; 0 with one irradiance word */
} gicube_lighting_report;

/* gicube/view.h: View */
enum { GICUBE_FILTER_BOX = 0, GICUBE_FILTER_TENT = 1 };
typedef struct gicube_cut_plane {
  double normal[3];
  double offset;
} gicube_cut_plane;
typedef struct gicube_lamp {
  gicube_light light; /* a rectangle or a sphere */
  double colour[3];
} gicube_lamp;
typedef struct gicube_view {
  uint32_t size;
  int32_t width, height;
  int32_t samples_per_axis;
  double eye[3], look_at[3], up[3];
  double fov_degrees;
  double orthographic_height;
  double step;
  double opacity_threshold;
  double exposure;
  int32_t filter;
  int32_t shade, jitter, leap, irradiance, scatter, high_albedo;
  int32_t lifetime;
  uint32_t seed;
  uint32_t cut_plane_count;
  const gicube_cut_plane* cut_planes;
  int32_t incident;
  int32_t reserved; /* 0 */
  const gicube_lamp* lamps;
  size_t lamp_count; /* at most 32 */
} gicube_view;

/* gicube/image.h: Pixel */
typedef struct gicube_pixel {
  uint8_t red, green, blue;
  uint8_t reserved;
  uint16_t alpha; /* 4095 = 1 */
} gicube_pixel;

/* gicube/ray.h: HostRay, TracedRay */
typedef struct gicube_host_ray {
  uint32_t id;
  uint32_t reserved;
  double position[3];
  double direction[3];
  double length;
  double energy;
} gicube_host_ray;
typedef struct gicube_traced_ray {
  uint32_t id;
  uint32_t reserved;
  double position[3];
  double direction[3];
  double colour[3];
  double opacity;
  double integral;
} gicube_traced_ray;

/* gicube/ray.h: RayRequest */
enum {
  GICUBE_RAY_INTEGRATE = 0,
  GICUBE_RAY_FIRST_HIT = 1,
  GICUBE_RAY_SEGMENT = 2,
  GICUBE_RAY_OPACITY = 3,
  GICUBE_RAY_DEPOSIT = 4,
  GICUBE_RAY_INTEGRAL = 5,
  GICUBE_RAY_BACKPROJECT = 6
};
enum { GICUBE_WORDS_IRRADIANCE = 0, GICUBE_WORDS_SUMS = 1 };
typedef struct gicube_ray_request {
  uint32_t size;
  int32_t type;
  double opacity;
  int32_t albedo;
  int32_t rules;
  int32_t lifetime;
  int32_t words; /* GICUBE_RAY_BACKPROJECT */
  double step;
  int32_t leap;
  int32_t reserved; /* 0 */
  /* The rays are sampled as those of this view (gicube/ray.h: Sampling). NULL: as those of the last view that this
   * handle has rendered, or of a default one. */
  const gicube_view* sampled_as;
} gicube_ray_request;

/* Rays that lie together, of several that make one batch. */
typedef struct gicube_ray_span {
  const gicube_host_ray* rays;
  size_t count;
} gicube_ray_span;

/* A line through several points, of version 0.2: its legs are GICUBE_RAY_SEGMENT rays, whose colour and opacity the
 * library adds up. */
typedef struct gicube_polyline {
  uint32_t id;
  uint32_t reserved;
  const double* points; /* x y z each, voxels */
  size_t point_count;   /* at least 2 */
} gicube_polyline;

/* gicube/ray.h: DepositReport */
typedef struct gicube_deposit_report {
  uint64_t rays, samples;
  double kept, clipped;
  uint64_t overflowed;
  double unit;
} gicube_deposit_report;

/* gicube/ray.h: BatchReport. Its `lighting` is a gicube_lighting_report up to `unit`, since a record grows at its end
 * alone. */
typedef struct gicube_batch_lighting {
  uint32_t size;
  uint32_t warnings;
  uint64_t rays;
  double emitted, deposited, escaped, scattered_away, given_up, clipped;
  double unit;
} gicube_batch_lighting;
typedef struct gicube_batch_report {
  uint32_t size;
  uint32_t ticket;
  uint64_t completed_ps; /* simulated time */
  uint64_t rays;         /* that come back: gicube_receive() writes so many */
  int32_t cancelled;
  int32_t deposited; /* 1: `lighting` says where the energy of a deposit went */
  gicube_batch_lighting lighting;
  int32_t backprojected; /* 1: `deposits` says what was left */
  int32_t reserved;
  gicube_deposit_report deposits;
  double escaped_by_face[6]; /* of lighting.escaped */
} gicube_batch_report;

/* gicube/pair.h: Element, ElementPair, PairRequest, PairFactor */
enum { GICUBE_ELEMENT_PATCH = 0, GICUBE_ELEMENT_BOX = 1, GICUBE_ELEMENT_TRIANGLE = 2, GICUBE_ELEMENT_DISC = 3 };
typedef struct gicube_element {
  int32_t kind;
  int32_t reserved; /* 0 */
  double origin[3], u[3], v[3];
  double w[3]; /* box, disc */
} gicube_element;
typedef struct gicube_element_pair {
  uint32_t a, b; /* indices of elements */
  uint32_t id;
  uint32_t reserved; /* 0 */
} gicube_element_pair;
enum { GICUBE_PAIR_RAYS_BY_BOARD = 0, GICUBE_PAIR_RAYS_BY_HOST = 1 };
typedef struct gicube_pair_request {
  uint32_t size;
  uint32_t rays; /* for each pair */
  uint32_t first;
  uint32_t seed;
  double opacity;
  int32_t made;
  int32_t leap;
  double step;
} gicube_pair_request;
typedef struct gicube_pair_factor {
  double transported;
  double geometric;
  double standard_error;
  int32_t clear;    /* 1: the empty flags prove a clear path, and no ray was sent */
  int32_t reserved; /* 0 */
} gicube_pair_factor;

/* NOLINTEND(modernize-use-using, readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
