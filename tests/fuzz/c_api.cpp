// Arguments of the C ABI, on one open board: no call crashes, reads or writes beyond what it was given, or answers with
// a fault of its own; bad arguments are named; the board is never lost.
#include "gicube/c_api.h"

#include <unistd.h>

#include <cstring>
#include <memory>
#include <thread>

#include "c_arguments.h"
#include "config/config.h"
#include "input.h"
#include "server/bus/board_slot.h"
#include "server/bus/bus_server.h"
#include "temporary_directory.h"

namespace gicube::fuzz {
namespace {

// A board process in this process.
class Server {
 public:
  Server()
      : slot_(0,
              emu::parse_config("threads: 1 asic { max_volume_voxels: 32 block_voxels: 8 } dsp { framebuffer_mb: 1 }")
                  .config) {
    uri_ = to_string(server_.listen(slot_, emu::parse_endpoint("unix:" + folder_.file("bus"))));
    thread_ = std::thread([this] { server_.run(); });
  }
  ~Server() {
    server_.stop();
    thread_.join();
  }
  const char* uri() const { return uri_.c_str(); }

 private:
  reference::TemporaryDirectory folder_;
  emu::BoardSlot slot_;
  emu::BusServer server_;
  std::string uri_;
  std::thread thread_;
};

struct Close {
  void operator()(gicube_board* board) const { gicube_close(board); }
};

int stop_sometimes(void* user, std::uint32_t, std::uint32_t) { return static_cast<Input*>(user)->below(8) == 7; }

int scatter(void* user, const gicube_scatter_event*, gicube_scatter_answer* answer) {
  Input& input = *static_cast<Input*>(user);
  put(input, answer->direction);
  answer->passes = input.number();
  return input.below(16) == 15;
}

void volume_call(gicube_board* board, Input& input) {
  static const std::vector<std::uint8_t> samples(4 * 18 * 18 * 18, 60);
  static const std::vector<float> values(18 * 18 * 18, 30.0F);
  std::vector<float> out(9 * 9 * 9);
  const gicube_box where = box(input);
  const std::size_t count =
      input.u8() == 255
          ? out.size()
          : static_cast<std::size_t>(std::abs(std::int64_t{where.size[0]} * where.size[1] * where.size[2])) %
                (out.size() + 1);
  double range[2];
  std::size_t damaged[4], damaged_count = 0;
  switch (input.u8() % 6) {
    case 0: {
      Argument<gicube_volume> volume(input, gicube_volume_init);
      if (gicube_volume* v = volume.whole()) {
        v->type = whole_number(input, 6);
        for (std::int32_t& edge : v->dims) edge = whole_number(input, 17);
        v->samples = samples.data();
        // All that is there, or just what the dims say.
        const std::int64_t all = std::int64_t{v->dims[0]} * v->dims[1] * v->dims[2];
        const std::int64_t width = v->type == 0 ? 1 : v->type == 4 ? 4 : 2;
        const bool fits = all > 0 && v->dims[0] < 18 && v->dims[1] < 18 && v->dims[2] < 18;
        v->sample_bytes = fits ? static_cast<std::size_t>(all * width) : samples.size();
        v->has_range = whole_number(input, 3);
        put(input, v->spacing);
        v->low = input.number();
        v->high = input.number();
      }
      return check(gicube_load_volume(board, volume.get(), stop_sometimes, &input));
    }
    case 1: return check(gicube_read_volume(board, &where, out.data(), count));
    case 2: return check(gicube_write_volume(board, &where, values.data(), count));
    case 3: return check(gicube_verify_volume(board, damaged, 4, &damaged_count));
    case 4: return check(gicube_value_range(board, &range[0], &range[1]));
    default: return check(gicube_read_irradiance(board, input.below(2) == 0 ? nullptr : &where, out.data(), count));
  }
}

void look_call(gicube_board* board, Input& input) {
  switch (input.u8() % 4) {
    case 0: {
      std::vector<gicube_colour_point> colours(input.below(4));
      std::vector<gicube_opacity_point> opacities(input.below(4));
      for (auto& point : colours) point.value = input.number(), put(input, point.colour);
      for (auto& point : opacities) point = {input.number(), input.number()};
      return check(gicube_set_transfer_function(board, whole_number(input, 5), colours.data(), colours.size(),
                                                opacities.data(), opacities.size()));
    }
    case 1: {
      Argument<gicube_shading> shading(input, gicube_shading_init);
      if (gicube_shading* s = shading.whole())
        s->ambient = input.number(), s->shininess = input.number(), put(input, s->light);
      return check(gicube_set_shading(board, shading.get()));
    }
    case 2: {
      Argument<gicube_material> material(input, gicube_material_init);
      const float parameters[40] = {0.5F, 1.3F};
      if (gicube_material* m = material.whole()) {
        m->bsdf = whole_number(input, 8);
        m->scattering = input.number();
        m->gloss = input.number();
        m->routine = input.below(2) == 0 ? GICUBE_HOST_ROUTINE : whole_number(input, 4);
        m->parameter_count = input.below(40);
        m->parameters = input.u8() == 255 ? nullptr : parameters;
      }
      return check(gicube_set_material(board, whole_number(input, 5), material.get()));
    }
    default: {
      std::vector<double> codes(3 * std::size_t{input.below(5)});
      for (double& number : codes) number = input.number();
      return check(gicube_set_gradient_codebook(board, codes.data(), codes.size() / 3));
    }
  }
}

void picture_call(gicube_board* board, Input& input) {
  static std::vector<gicube_pixel> pixels(16 * 16);
  if (input.u8() % 3 == 0) {
    std::vector<gicube_light> lights(input.below(3));
    for (gicube_light& light : lights) {
      light.kind = whole_number(input, 5);
      put(input, light.position);
      put(input, light.edge_u);
      put(input, light.edge_v);
      light.radius = input.number();
      light.power = input.number();
    }
    Argument<gicube_illumination> settings(input, gicube_illumination_init);
    if (gicube_illumination* s = settings.whole()) {
      s->albedo = whole_number(input, 3);
      s->rules = whole_number(input, 3);
      s->rays_per_face_voxel = static_cast<std::int32_t>(input.below(3));
      s->lifetime = whole_number(input, 5) % 8;
      s->step = input.number();
    }
    Argument<gicube_lighting_report> report(input, gicube_lighting_report_init);
    check(gicube_illuminate(board, lights.data(), lights.size(), settings.get(), stop_sometimes, &input, report.get()));
    gicube_lighting_warning(board, input.u8());
    return;
  }
  Argument<gicube_view> view(input, gicube_view_init);
  std::array<gicube_cut_plane, 8> planes{};
  std::size_t count = pixels.size();
  if (gicube_view* v = view.whole()) {
    v->width = whole_number(input, 17);
    v->height = whole_number(input, 17);
    v->samples_per_axis = whole_number(input, 3);
    put(input, v->eye);
    put(input, v->look_at);
    v->fov_degrees = input.below(2) == 0 ? 40 : input.number();
    v->orthographic_height = input.below(2) == 0 ? 0 : input.number();
    v->step = input.below(2) == 0 ? 1 : input.number();
    v->opacity_threshold = input.below(2) == 0 ? 1 : input.number();
    v->filter = whole_number(input, 3);
    v->scatter = whole_number(input, 2);
    v->lifetime = whole_number(input, 9) % 16;
    v->cut_plane_count = input.below(9);
    v->cut_planes = planes.data();
    for (gicube_cut_plane& plane : planes) put(input, plane.normal);
    const std::int64_t all = std::int64_t{v->width} * v->height;
    if (input.u8() != 255 && all > 0 && all <= std::ssize(pixels)) count = static_cast<std::size_t>(all);
    // What the call may write is bounded by `count`, whatever the view says.
  }
  check(gicube_render(board, view.get(), pixels.data(), count, stop_sometimes, &input));
}

// The descriptor of batch `last`, or of any.
void descriptor_call(gicube_board* board, Input& input, std::uint32_t last) {
  constexpr int kUntouched = -2;
  int descriptor = kUntouched;
  const std::uint32_t ticket = input.u8() == 255 ? input.u32() : last;
  const bool is_null = input.u8() == 255;
  const gicube_status status = gicube_batch_descriptor(board, ticket, is_null ? nullptr : &descriptor);
  check(status);
  if (status == GICUBE_OK) return expect(::close(descriptor) == 0, "a batch's descriptor is the caller's");
  expect(descriptor == (is_null ? kUntouched : -1), "a failure leaves no descriptor");
}

void ray_call(gicube_board* board, Input& input) {
  static std::uint32_t last = 0;
  static std::size_t last_count = 0;
  Argument<gicube_batch_report> report(input, gicube_batch_report_init);
  std::vector<gicube_host_ray> rays(input.below(6));
  for (gicube_host_ray& each : rays) each = ray(input);
  Argument<gicube_ray_request> request(input, gicube_ray_request_init);
  if (gicube_ray_request* r = request.whole()) {
    r->type = whole_number(input, 8);
    r->words = whole_number(input, 3);
    r->opacity = input.below(2) == 0 ? 1 : input.number();
    r->lifetime = static_cast<std::int32_t>(input.below(8));
  }
  std::uint32_t ticket = 0;
  std::int32_t cancelled = 0;
  switch (input.u8() % 8) {
    case 0:
    case 1: check(gicube_submit(board, rays.data(), rays.size(), request.get(), &ticket)); break;
    case 2: {
      const gicube_ray_span spans[2] = {{rays.data(), rays.size() / 2},
                                        {rays.data() + rays.size() / 2, rays.size() - rays.size() / 2}};
      check(gicube_submit_gather(board, spans, 2, request.get(), &ticket));
      break;
    }
    case 3: {
      std::vector<double> points(3 * std::size_t{input.below(5)});
      for (double& number : points) number = input.number();
      const gicube_polyline line{1, 0, points.data(), points.size() / 3};
      check(gicube_submit_polylines(board, &line, 1, &ticket));
      if (ticket != 0) last = ticket, last_count = points.size() / 3 - 1;
      return;
    }
    case 4: return check(gicube_cancel(board, input.u8() == 255 ? input.u32() : last, &cancelled));
    case 5: {
      std::vector<gicube_traced_ray> traced(input.u8() == 255 ? input.u8() : last_count);
      return check(gicube_receive(board, last, input.u8() == 255 ? input.u64() : GICUBE_NO_DEADLINE, traced.data(),
                                  traced.size(), report.get()));
    }
    case 6: return descriptor_call(board, input, last);
    default: return check(gicube_poll(board, report.get()));
  }
  if (ticket != 0) last = ticket, last_count = rays.size();
}

void pair_call(gicube_board* board, Input& input) {
  std::vector<gicube_element> elements(input.below(4));
  for (gicube_element& element : elements) {
    element.kind = whole_number(input, 5);
    put(input, element.origin);
    put(input, element.u);
    put(input, element.v);
    put(input, element.w);
  }
  std::vector<gicube_element_pair> pairs(input.below(4));
  for (gicube_element_pair& pair : pairs) {
    pair.a = input.below(4);
    pair.b = input.u8() == 255 ? input.u32() : input.below(4);
    pair.id = input.u8();
  }
  Argument<gicube_pair_request> request(input, gicube_pair_request_init);
  if (gicube_pair_request* r = request.whole()) {
    r->rays = input.below(17);
    r->opacity = input.below(2) == 0 ? 1 : input.number();
    r->made = whole_number(input, 3);
    r->step = input.below(2) == 0 ? 1 : input.number();
  }
  std::vector<gicube_pair_factor> factors(input.u8() == 255 ? input.u8() : pairs.size());
  const gicube_status status =
      gicube_pair_factors(board, elements.data(), elements.size(), pairs.data(), pairs.size(), request.get(),
                          stop_sometimes, &input, factors.data(), factors.size());
  check(status);
  if (status != GICUBE_OK) return;
  for (const gicube_pair_factor& factor : factors) {
    expect(factor.transported >= 0 && factor.geometric >= 0 && factor.standard_error >= 0, "factors are not negative");
  }
}

void other_call(gicube_board* board, Input& input) {
  std::uint64_t now = 0;
  switch (input.u8() % 10) {
    case 0: return check(gicube_now(board, input.u8() == 255 ? nullptr : &now));
    case 1: return check(gicube_host_compute(board, input.u8() == 255 ? input.u64() : input.u32()));
    case 2: return check(gicube_set_time_limit(board, input.u32()));
    case 3: {
      gicube_counter_list* list = nullptr;
      check(gicube_get_counters(board, &list));
      const char* name = nullptr;
      std::uint64_t value = 0;
      const gicube_status found = gicube_counters_at(list, input.u8(), &name, nullptr, &value);
      check(found);
      if (found == GICUBE_OK) check(gicube_counters_value(list, name, &value));
      return gicube_counters_free(list);
    }
    case 4:
      return check(gicube_set_scattering_routine(board, input.below(2) == 0 ? nullptr : scatter, &input, input.u16()));
    case 5: {
      check(input.below(2) == 0 ? gicube_clear_irradiance(board, input.number())
                                : gicube_clear_sums(board, input.number()));
      const gicube_box box{{0, 0, 0}, {2, static_cast<std::int32_t>(input.below(4)), 2}};
      std::vector<float> sums(input.below(20));
      return check(gicube_read_sums(board, &box, sums.data(), sums.size()));
    }
    case 6: {
      Argument<gicube_board_info> info(input, gicube_board_info_init);
      return check(gicube_get_info(board, info.get()));
    }
    case 8: {
      std::int32_t size[2] = {};
      check(gicube_get_framebuffer_size(board, &size[0], &size[1]));
      std::vector<gicube_pixel> pixels(input.u8() == 255 ? input.u8() : static_cast<std::size_t>(size[0] * size[1]));
      return check(gicube_read_framebuffer(board, pixels.data(), pixels.size()));
    }
    case 9: {
      std::int32_t blocks[3];
      check(gicube_get_blocks(board, blocks));
      const gicube_box where = box(input);
      std::vector<float> values(input.below(65));
      for (float& value : values) value = static_cast<float>(input.number());
      return check(
          gicube_write_irradiance(board, input.below(8) == 0 ? nullptr : &where, values.data(), values.size()));
    }
    default: {
      std::vector<std::uint8_t> flags(input.below(30), 1);
      return check(input.below(2) == 0 ? gicube_set_empty_flags(board, flags.data(), flags.size())
                                       : gicube_get_empty_flags(board, flags.data(), flags.size()));
    }
  }
}

// Inputs share boards, since each makes its gradient codebook anew: one that asks for it, and every hundredth, gets its
// own.
gicube_board* board_for(Input& input) {
  static const Server server;
  static std::unique_ptr<gicube_board, Close> board;
  static int inputs = 0;
  std::uint64_t now = 0;
  if (board) check(gicube_now(board.get(), &now));
  const bool is_old = now >> 60 != 0;  // near the end of simulated time, where a board refuses to go on
  if (input.u8() >= 240 || ++inputs % 100 == 0 || is_old) board.reset();
  if (board) return board.get();
  gicube_board* opened = nullptr;
  Argument<gicube_open_options> options(input, gicube_open_options_init);
  if (gicube_open_options* o = options.whole()) o->back_pressure = whole_number(input, 3);
  const gicube_status status = gicube_open(server.uri(), options.get(), &opened);
  check(status);
  board.reset(opened);
  expect((status == GICUBE_OK) == (opened != nullptr), "there is a board if it could be opened");
  return opened;
}

}  // namespace

void c_api(Bytes bytes) {
  Input input(bytes);
  gicube_board* board = board_for(input);
  for (int calls = 0; board != nullptr && !input.empty() && calls < 60; ++calls) {
    gicube_board* target = input.u8() == 255 ? nullptr : board;
    switch (input.u8() % 6) {
      case 0: volume_call(target, input); break;
      case 1: look_call(target, input); break;
      case 2: picture_call(target, input); break;
      case 3: ray_call(target, input); break;
      case 4: other_call(target, input); break;
      default: pair_call(target, input); break;
    }
  }
  if (board == nullptr) return;
  // What must not outlive this input, or would keep the next ones from working.
  check(gicube_set_scattering_routine(board, nullptr, nullptr, 0));
  check(gicube_set_time_limit(board, 0));
}

}  // namespace gicube::fuzz
