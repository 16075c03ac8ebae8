/* A host program in C: a volume, a picture, rays of its own. Prints what it saw; c_host [BOARD]. */
#include <gicube/c_api.h>
#include <stdio.h>
#include <stdlib.h>

enum { kEdge = 32, kWidth = 64, kHeight = 48, kRays = 100 };

/* Says what went wrong, and where. */
static int failed(const char* what) {
  fprintf(stderr, "c_host: %s: %s\n", what, gicube_last_error());
  return 1;
}

/* A cube of 16 voxels with the value 200 in the middle of one of 32. */
static int load_cube(gicube_board* board) {
  static uint8_t voxels[kEdge * kEdge * kEdge];
  for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
    const int x = i % kEdge, y = i / kEdge % kEdge, z = i / (kEdge * kEdge);
    voxels[i] = x >= 8 && x < 24 && y >= 8 && y < 24 && z >= 8 && z < 24 ? 200 : 0;
  }
  gicube_volume volume;
  gicube_volume_init(&volume, sizeof volume);
  volume.type = GICUBE_SAMPLE_UINT8;
  volume.dims[0] = volume.dims[1] = volume.dims[2] = kEdge;
  volume.samples = voxels;
  volume.sample_bytes = sizeof voxels;
  if (gicube_load_volume(board, &volume, NULL, NULL) != GICUBE_OK) return failed("load");

  const gicube_colour_point colours[] = {{0, {1, 0.5, 0.25}}};
  const gicube_opacity_point opacities[] = {{100, 0}, {100, 1}};
  if (gicube_set_transfer_function(board, 0, colours, 1, opacities, 2) != GICUBE_OK) return failed("transfer function");
  return 0;
}

static int render(gicube_board* board) {
  static gicube_pixel pixels[kWidth * kHeight];
  gicube_view view;
  gicube_view_init(&view, sizeof view);
  view.eye[0] = view.eye[1] = 15.5;
  view.eye[2] = -80;
  view.look_at[0] = view.look_at[1] = view.look_at[2] = 15.5;
  view.width = kWidth;
  view.height = kHeight;
  if (gicube_render(board, &view, pixels, kWidth * kHeight, NULL, NULL) != GICUBE_OK) return failed("render");
  if (gicube_why_invisible(board) != NULL) fprintf(stderr, "%s\n", gicube_why_invisible(board));
  int opaque = 0;
  for (int i = 0; i < kWidth * kHeight; ++i) opaque += pixels[i].alpha > 4000;
  printf("picture: %d of %d pixels opaque\n", opaque, kWidth * kHeight);
  return 0;
}

/* Rays along z: the first 50 meet the cube, the others miss it. */
static int trace(gicube_board* board) {
  gicube_host_ray rays[kRays] = {{0}};
  gicube_traced_ray traced[kRays];
  for (int i = 0; i < kRays; ++i) {
    rays[i].id = (uint32_t)i;
    rays[i].position[0] = i < 50 ? 12 : 2;
    rays[i].position[1] = 10 + i % 10;
    rays[i].direction[2] = 1;
  }
  uint32_t ticket = 0;
  if (gicube_submit(board, rays, kRays, NULL, &ticket) != GICUBE_OK) return failed("submit");
  gicube_host_compute(board, 1000000); /* this program works for a microsecond of simulated time */
  gicube_batch_report report;
  gicube_batch_report_init(&report, sizeof report);
  if (gicube_receive(board, ticket, GICUBE_NO_DEADLINE, traced, kRays, &report) != GICUBE_OK) return failed("receive");
  int hits = 0;
  for (int i = 0; i < kRays; ++i) hits += traced[i].opacity > 0.9;
  printf("rays: %d of %d met the cube, back at %.3f simulated us\n", hits, kRays, (double)report.completed_ps * 1e-6);
  return 0;
}

int main(int argc, char** argv) {
  gicube_board* board = NULL;
  if (gicube_open(argc > 1 ? argv[1] : "emu:", NULL, &board) != GICUBE_OK) return failed("open");
  const int result = load_cube(board) || render(board) || trace(board);
  gicube_counter_list* counters = NULL;
  uint64_t bytes = 0;
  if (gicube_get_counters(board, &counters) == GICUBE_OK) gicube_counters_value(counters, "bus.rays.bytes", &bytes);
  printf("bus: %llu bytes of rays\n", (unsigned long long)bytes);
  gicube_counters_free(counters);
  gicube_close(board);
  return result;
}
