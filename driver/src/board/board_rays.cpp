// Rays of the host application.
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "encode/argument.h"
#include "encode/camera.h"
#include "encode/host_ray.h"
#include "gicube/ray_tracer.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {
namespace {

// The handle of a batch. The board traces it without a thread of the driver, so a ticket and a descriptor suffice.
class SentBatch final : public OperationOf<RayBatch> {
 public:
  SentBatch(std::weak_ptr<BoardState> board, Ticket ticket, Fd ended)
      : board_(std::move(board)), ticket_(ticket), ended_(std::move(ended)) {}

  bool wait(std::chrono::milliseconds timeout) override {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds kAtOnce = std::chrono::hours(24);
    const bool is_long = timeout > kAtOnce;  // poll() takes an int of milliseconds
    const auto end = Clock::now() + std::min(timeout, kAtOnce);
    for (;;) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
      pollfd polled{ended_.get(), POLLIN, 0};
      const int found = ::poll(&polled, 1, static_cast<int>(std::max(left, std::chrono::milliseconds(0)).count()));
      if (found > 0) return true;
      if (found == 0) return is_long && wait(timeout - kAtOnce);
      if (errno != EINTR) throw Error(std::string("waiting for a batch: ") + std::strerror(errno));
    }
  }
  bool cancel() override { return RayTracer(*open_board()).cancel(ticket_); }
  PendingProgress progress() const override { return {}; }
  Fd descriptor() override { return duplicate(ended_); }
  RayBatch take(Picoseconds deadline) override { return RayTracer(*open_board()).receive(ticket_, deadline); }

 private:
  std::shared_ptr<BoardState> open_board() const {
    if (auto board = board_.lock()) return board;
    throw DeviceLost("the board is lost: the application has closed it", Loss::kClosed);
  }

  const std::weak_ptr<BoardState> board_;
  const Ticket ticket_;
  const Fd ended_;
};

}  // namespace

Ticket BoardState::submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request,
                          std::span<const std::size_t> numbers) {
  if (!info.host_rays) throw Unsupported("this board takes no host rays");
  check(request);
  check(request.sampling);
  const LoadedVolume& of = request.type == RayType::kBackproject ? whole("RayType::kBackproject") : loaded("submit()");
  check_drift("request.step", request.step);
  const bool deposits = request.type == RayType::kDeposit;
  if (deposits && irradiance_unit <= 0) {
    throw Rejected("RayType::kDeposit needs a unit of energy: call clear_irradiance() or illuminate() first");
  }
  if (deposits) need_colours_on_card("RayType::kDeposit");
  const bool backprojects = request.type == RayType::kBackproject, sums = request.words == SumWords::kSums;
  if (backprojects && (sums ? sum_unit : irradiance_unit) <= 0) {
    throw Rejected(std::string("RayType::kBackproject needs a unit of its words: call ") +
                   (sums ? "clear_sums()" : "clear_irradiance()") + " first");
  }
  if (backprojects && !sums && info.irradiance_words > 1) {
    throw Unsupported(
        "backprojection into irradiance words needs a board with one word per voxel (asic.irradiance_words)");
  }
  const bool gathers_colour = request.type == RayType::kIntegrate || request.type == RayType::kSegment;
  if (gathers_colour && request.sampling.irradiance && irradiance_unit <= 0) {
    throw Rejected("request.sampling.irradiance needs light: call illuminate() first");
  }
  const View sampled = view_of(request);
  const Vec3 to_eye = towards_eye(sampled, of.relative_spacing);
  RaySetup setup{request,
                 of.dims,
                 backprojects && sums ? sum_unit : irradiance_unit,
                 info.wide,
                 sampled,
                 to_eye,
                 of.min_spacing * of.relative_spacing,
                 of.range,
                 static_cast<std::size_t>(info.irradiance_words)};
  std::size_t index = 0;
  for (std::size_t list = 0; list < rays.size(); ++list) {
    if (!numbers.empty()) index = numbers[list];
    for (const HostRay& ray : rays[list]) check(ray, index++, setup);
  }
  set_sampling(sampled);
  if (deposits) setup.warnings = tables.light_warnings(request.albedo, request.rules, request.step);
  if (deposits || backprojects) device.set_register(wire::reg::kSeed, sampled.seed);
  if (gathers_colour && sampled.shade) tables.send_reflectance(to_eye);
  if (!bricks) return batches.submit(rays, setup);
  if (shared) share_anew();
  BrickRun run;
  run.of = {.of = wire::RaysOf::kTrace, .trace = trace_header(request, 0)};
  if (deposits) {
    run.needs.light = LightUse::kLeft;
    run.take_ledger = [](const wire::LightingLedger&) {};
  } else if (gathers_colour && sampled.irradiance) {
    run.needs.light = LightUse::kSeen;
  }
  return batches.submit(rays, setup, [&](std::span<const EncodedRays> parts) {
    return deposits ? deposit_in_bricks(parts, run) : trace_in_bricks(parts, run);
  });
}

Pending<RayBatch> BoardState::handle_of(Ticket ticket) {
  return Pending<RayBatch>(std::make_shared<SentBatch>(weak_from_this(), ticket, batches.descriptor(ticket)));
}

Ticket RayTracer::submit(std::span<const HostRay> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->submit(std::span(&rays, 1), request);
}

Ticket RayTracer::submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->submit(rays, request);
}

Pending<RayBatch> RayTracer::start(std::span<const HostRay> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->handle_of(state_->submit(std::span(&rays, 1), request));
}

RayBatch RayTracer::receive(Ticket ticket, Picoseconds deadline) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.receive(ticket, deadline);
}

BatchReport RayTracer::receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.receive(ticket, rays, deadline);
}

std::vector<RayBatch> RayTracer::poll() {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.poll();
}

bool RayTracer::cancel(Ticket ticket) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.cancel(ticket);
}

int RayTracer::descriptor(Ticket ticket) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.descriptor(ticket).release();
}

void Board::set_time_limit(Picoseconds limit) {
  const auto lock = state_->begin();
  state_->time_limit = limit;
}

}  // namespace gicube
