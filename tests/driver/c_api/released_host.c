/* A host in C as it was compiled for a past release: this file is built with the headers of that release
 * (released/VERSION), and runs on the library of today. It hands over every record that has a size, and looks whether
 * the library writes beyond one. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gicube/c_api.h"

enum { kEdge = 32, kWidth = 40, kHeight = 30, kRays = 100, kAfter = 256 };

static void fail(const char* what) {
  fprintf(stderr, "released_host: %s: %s\n", what, gicube_last_error());
  exit(1);
}

static void check(gicube_status status, const char* what) {
  if (status != GICUBE_OK) fail(what);
}

static void expect(int holds, const char* what) {
  if (!holds) fail(what);
}

/* A record, with memory of the host's behind it. */
#define RECORD(type)             \
  struct {                       \
    type record;                 \
    unsigned char after[kAfter]; \
  }
#define INIT(init, whole) \
  (memset(&(whole), 0x5A, sizeof(whole)), check(init(&(whole).record, sizeof(whole).record), #init))
#define EXPECT_UNTOUCHED(whole)                                                       \
  for (int k = 0; k < kAfter; ++k) expect((whole).after[k] == 0x5A, "after " #whole); \
  expect((whole).record.size == sizeof(whole).record, "the size of " #whole)

static gicube_board* opened(void) {
  RECORD(gicube_open_options) options;
  INIT(gicube_open_options_init, options);
  options.record.max_rays = 8192;
  gicube_board* board = NULL;
  check(gicube_open("emu:?set=asic.processors=3", &options.record, &board), "open");
  EXPECT_UNTOUCHED(options);
  RECORD(gicube_board_info) info;
  INIT(gicube_board_info_init, info);
  check(gicube_get_info(board, &info.record), "info");
  EXPECT_UNTOUCHED(info);
  expect(info.record.processors == 3 && info.record.host_rays == 1, "what the board is");
  return board;
}

/* A cube of 16 voxels with the value 200 in the middle of one of 32. */
static void load(gicube_board* board) {
  static uint8_t voxels[kEdge * kEdge * kEdge];
  for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
    const int x = i % kEdge, y = i / kEdge % kEdge, z = i / (kEdge * kEdge);
    voxels[i] = x >= 8 && x < 24 && y >= 8 && y < 24 && z >= 8 && z < 24 ? 200 : 0;
  }
  RECORD(gicube_volume) volume;
  INIT(gicube_volume_init, volume);
  volume.record.type = GICUBE_SAMPLE_UINT8;
  for (int axis = 0; axis < 3; ++axis) volume.record.dims[axis] = kEdge;
  volume.record.samples = voxels;
  volume.record.sample_bytes = sizeof voxels;
  check(gicube_load_volume(board, &volume.record, NULL, NULL), "load");
  EXPECT_UNTOUCHED(volume);
  const gicube_colour_point colours[] = {{0, {1, 0.5, 0.25}}};
  const gicube_opacity_point opacities[] = {{100, 0}, {100, 1}};
  check(gicube_set_transfer_function(board, 0, colours, 1, opacities, 2), "transfer function");
  RECORD(gicube_shading) shading;
  INIT(gicube_shading_init, shading);
  shading.record.ambient = 1;
  check(gicube_set_shading(board, &shading.record), "shading");
  EXPECT_UNTOUCHED(shading);
  RECORD(gicube_material) material;
  INIT(gicube_material_init, material);
  material.record.scattering = 0.25;
  check(gicube_set_material(board, 0, &material.record), "material");
  EXPECT_UNTOUCHED(material);
}

/* All that a light emits has gone somewhere. */
static void illuminate(gicube_board* board) {
  gicube_light light;
  memset(&light, 0, sizeof light);
  light.kind = GICUBE_LIGHT_DIRECTIONAL;
  light.position[2] = -1;
  light.power = 1;
  RECORD(gicube_illumination) settings;
  INIT(gicube_illumination_init, settings);
  settings.record.rays_per_face_voxel = 1;
  RECORD(gicube_lighting_report) report;
  INIT(gicube_lighting_report_init, report);
  check(gicube_illuminate(board, &light, 1, &settings.record, NULL, NULL, &report.record), "illuminate");
  EXPECT_UNTOUCHED(settings);
  EXPECT_UNTOUCHED(report);
  const gicube_lighting_report* r = &report.record;
  const double gone = r->deposited + r->escaped + r->scattered_away + r->given_up + r->clipped;
  expect(r->emitted > 0 && fabs(gone / r->emitted - 1) < 0.01, "the light's energy");
}

static int render(gicube_board* board) {
  static gicube_pixel pixels[kWidth * kHeight];
  RECORD(gicube_view) view;
  INIT(gicube_view_init, view);
  view.record.eye[0] = view.record.eye[1] = 15.5;
  view.record.eye[2] = -80;
  for (int axis = 0; axis < 3; ++axis) view.record.look_at[axis] = 15.5;
  view.record.width = kWidth;
  view.record.height = kHeight;
  check(gicube_render(board, &view.record, pixels, kWidth * kHeight, NULL, NULL), "render");
  EXPECT_UNTOUCHED(view);
  int opaque = 0;
  for (int i = 0; i < kWidth * kHeight; ++i) opaque += pixels[i].alpha > 4000;
  return opaque;
}

/* Rays along z: the first 50 meet the cube's face, where the value passes 100 between the voxels 7 and 8. */
static int first_hits(gicube_board* board) {
  gicube_host_ray rays[kRays];
  gicube_traced_ray traced[kRays];
  memset(rays, 0, sizeof rays);
  for (int i = 0; i < kRays; ++i) {
    rays[i].id = (uint32_t)i;
    rays[i].position[0] = i < 50 ? 12 : 2;
    rays[i].position[1] = 10 + i % 10;
    rays[i].direction[2] = 1;
  }
  RECORD(gicube_ray_request) request;
  INIT(gicube_ray_request_init, request);
  request.record.type = GICUBE_RAY_FIRST_HIT;
  uint32_t ticket = 0;
  check(gicube_submit(board, rays, kRays, &request.record, &ticket), "submit");
  EXPECT_UNTOUCHED(request);
  RECORD(gicube_batch_report) report;
  INIT(gicube_batch_report_init, report);
  check(gicube_receive(board, ticket, GICUBE_NO_DEADLINE, traced, kRays, &report.record), "receive");
  EXPECT_UNTOUCHED(report);
  expect(report.record.ticket == ticket && report.record.rays == kRays, "the batch");
  int hits = 0;
  for (int i = 0; i < kRays; ++i) hits += traced[i].opacity > 0.9 && fabs(traced[i].position[2] - 7.5) <= 0.5;
  return hits;
}

/* Two squares face one another over a distance of their side: the form factor is 0.19982. */
static double form_factor(gicube_board* board) {
  gicube_element elements[2];
  memset(elements, 0, sizeof elements);
  for (int i = 0; i < 2; ++i) {
    for (int axis = 0; axis < 2; ++axis) elements[i].origin[axis] = 1;
    elements[i].origin[2] = 2 + 4 * i;
    elements[i].u[i] = 4;
    elements[i].v[1 - i] = 4;
  }
  const gicube_element_pair pair = {0, 1, 0, 0};
  RECORD(gicube_pair_request) request;
  INIT(gicube_pair_request_init, request);
  request.record.rays = 4096;
  gicube_pair_factor factor;
  check(gicube_pair_factors(board, elements, 2, &pair, 1, &request.record, NULL, NULL, &factor, 1), "pair factors");
  EXPECT_UNTOUCHED(request);
  return 16 * factor.transported;
}

int main(void) {
  gicube_board* const board = opened();
  load(board);
  const int hits = first_hits(board);
  const double factor = form_factor(board);
  illuminate(board);
  const int opaque = render(board);
  gicube_close(board);
  printf("%d of %d rays hit the cube, form factor %.3f, picture %s\n", hits, kRays, factor,
         opaque > 0 ? "visible" : "empty");
  return 0;
}
