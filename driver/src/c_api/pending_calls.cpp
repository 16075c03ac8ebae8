// Calls that run while the application does something else.
#include <chrono>
#include <variant>

#include "call.h"

struct GICUBE_HIDDEN gicube_pending {
  using Factors = gicube::Pending<std::vector<gicube::PairFactor>>;

  template <typename Call>
  gicube_pending(gicube_board& of, Call started, std::size_t results_given = 0)
      : board(of), call(std::move(started)), results(results_given) {}

  gicube_board& board;
  std::variant<gicube::Pending<void>, gicube::Pending<gicube::Image>, gicube::Pending<gicube::LightingReport>, Factors>
      call;
  std::size_t results;  // pixels or factors
  gicube::View view{};  // of a picture
};

namespace gicube::c_api {
namespace {

constexpr std::uint64_t kLongestWait = 1000ull * 60 * 60 * 24 * 365;  // ms, chosen: a year, which fits the clock

const PendingCall& call_of(const gicube_pending& pending) {
  return std::visit([](const auto& each) -> const PendingCall& { return each; }, pending.call);
}

template <typename T>
Pending<T>& started_as(gicube_pending* pending, const char* what) {
  auto* found = std::get_if<Pending<T>>(&checked("pending", pending).call);
  if (found == nullptr) throw BadArgument("pending", std::string("one of ") + what, "the handle of another call");
  return *found;
}

// Starts a call of a board: work(its handle) makes what *pending becomes.
template <typename Work>
gicube_status start(gicube_board* board, gicube_pending** pending, const Work& work) {
  return call([&] {
    checked("pending", pending) = nullptr;
    *pending = work(checked_board(board));
  });
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_start_load_volume(gicube_board* board, const gicube_volume* volume, gicube_pending** pending) {
  return start(board, pending, [&](gicube_board& handle) {
    return new gicube_pending(handle, handle.board.volume().start_load(to_volume(volume)));
  });
}

gicube_status gicube_start_render(gicube_board* board, const gicube_view* view, gicube_pending** pending) {
  return start(board, pending, [&](gicube_board& handle) {
    const gicube::View picture = to_view(view, "view");
    const bool some = picture.width > 0 && picture.height > 0;  // otherwise the driver names what is wrong with them
    const auto pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    auto* made = new gicube_pending(handle, handle.board.renderer().start(picture), some ? pixels : 0);
    made->view = picture;
    return made;
  });
}

gicube_status gicube_start_illuminate(gicube_board* board, const gicube_light* lights, size_t count,
                                      const gicube_illumination* settings, gicube_pending** pending) {
  return start(board, pending, [&](gicube_board& handle) {
    return new gicube_pending(handle, handle.board.light().start(from_records<gicube::Light>("lights", lights, count),
                                                                 to_illumination(settings)));
  });
}

gicube_status gicube_start_pair_factors(gicube_board* board, const gicube_element* elements, size_t element_count,
                                        const gicube_element_pair* pairs, size_t pair_count,
                                        const gicube_pair_request* request, gicube_pending** pending) {
  return start(board, pending, [&](gicube_board& handle) {
    const auto how = read_optional<gicube::PairRequest>("request", request);
    const auto all = from_records<gicube::Element>("elements", elements, element_count);
    const auto between = from_records<gicube::ElementPair>("pairs", pairs, pair_count);
    return new gicube_pending(handle, handle.board.pairs().start(all, between, how), pair_count);
  });
}

gicube_status gicube_pending_wait(const gicube_pending* pending, uint64_t timeout_ms, int32_t* ready) {
  return call([&] {
    checked("ready", ready) = 0;
    const std::chrono::milliseconds timeout(std::min(timeout_ms, kLongestWait));
    *ready = call_of(checked("pending", pending)).wait(timeout) ? 1 : 0;
  });
}

gicube_status gicube_pending_cancel(gicube_pending* pending, int32_t* cancelled) {
  return call([&] {
    checked("cancelled", cancelled) = 0;
    *cancelled = std::visit([](auto& each) { return each.cancel(); }, checked("pending", pending).call) ? 1 : 0;
  });
}

gicube_status gicube_pending_progress(const gicube_pending* pending, uint32_t* done, uint32_t* all) {
  return call([&] {
    checked("done", done);
    checked("all", all);
    const gicube::PendingProgress progress = call_of(checked("pending", pending)).progress();
    *done = progress.done;
    *all = progress.all;
  });
}

gicube_status gicube_pending_descriptor(const gicube_pending* pending, int* descriptor) {
  return call([&] {
    checked("descriptor", descriptor) = -1;
    *descriptor = call_of(checked("pending", pending)).descriptor();
  });
}

gicube_status gicube_finish_load_volume(gicube_pending* pending, uint64_t deadline_ps) {
  return call([&] { started_as<void>(pending, "gicube_start_load_volume()").get(deadline_ps); });
}

gicube_status gicube_finish_render(gicube_pending* pending, uint64_t deadline_ps, gicube_pixel* pixels, size_t count) {
  return call([&] {
    auto& started = started_as<gicube::Image>(pending, "gicube_start_render()");
    checked("pixels", pixels);
    if (pending->results > 0) check_count("count", count, pending->results);
    const gicube::Image image = started.get(deadline_ps);
    remember_view(pending->board, pending->view);
    hand_over(pending->board, image, pixels, count);
  });
}

gicube_status gicube_finish_illuminate(gicube_pending* pending, uint64_t deadline_ps, gicube_lighting_report* report) {
  return call([&] {
    auto& started = started_as<gicube::LightingReport>(pending, "gicube_start_illuminate()");
    check_optional("report", report);
    hand_over(pending->board, started.get(deadline_ps), report);
  });
}

gicube_status gicube_finish_pair_factors(gicube_pending* pending, uint64_t deadline_ps, gicube_pair_factor* factors,
                                         size_t count) {
  return call([&] {
    auto& started = started_as<std::vector<gicube::PairFactor>>(pending, "gicube_start_pair_factors()");
    check_count("count", count, pending->results);
    checked("factors", factors, count);
    for (const gicube::PairFactor& factor : started.get(deadline_ps))
      *factors++ = to_record<gicube_pair_factor>(factor);
  });
}

void gicube_pending_free(gicube_pending* pending) { delete pending; }
}
