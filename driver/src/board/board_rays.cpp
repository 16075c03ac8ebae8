// Rays of the host application.
#include <string>

#include "encode/argument.h"
#include "encode/host_ray.h"
#include "gicube/wire/registers.h"
#include "state.h"

namespace gicube {

Ticket Board::State::submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request,
                            std::vector<std::size_t> lines, std::span<const std::size_t> numbers) {
  if (!info.host_rays) throw Unsupported("this board takes no host rays");
  check(request);
  const LoadedVolume& of = request.type == RayType::kBackproject ? whole("RayType::kBackproject") : loaded("submit()");
  check_drift("request.step", request.step);
  const bool deposits = request.type == RayType::kDeposit;
  if (deposits && irradiance_unit <= 0) {
    throw Rejected("rays that deposit need a unit of energy: clear_irradiance() or illuminate() first");
  }
  if (deposits) need_colours_on_card("RayType::kDeposit");
  const bool backprojects = request.type == RayType::kBackproject, sums = request.words == SumWords::kSums;
  if (backprojects && (sums ? sum_unit : irradiance_unit) <= 0) {
    throw Rejected(std::string("rays that backproject need a unit of what they leave: ") +
                   (sums ? "clear_sums()" : "clear_irradiance()") + " first");
  }
  if (backprojects && !sums && info.irradiance_words > 1) {
    throw Unsupported(
        "backprojection into irradiance words needs a board with one of them a voxel (asic.irradiance_words)");
  }
  View sampled = sampling;
  sampled.step = request.step, sampled.leap = request.leap;
  const RaySetup setup{request,
                       of.dims,
                       backprojects && sums ? sum_unit : irradiance_unit,
                       info.wide,
                       sampled,
                       sampling_towards_eye,
                       of.min_spacing * of.relative_spacing,
                       of.range,
                       static_cast<std::size_t>(info.irradiance_words)};
  std::size_t index = 0;
  for (std::size_t list = 0; list < rays.size(); ++list) {
    if (!numbers.empty()) index = numbers[list];
    for (const HostRay& ray : rays[list]) check(ray, index++, setup);
  }
  set_sampling(sampled);
  if (deposits || backprojects) device.set_register(wire::reg::kSeed, sampling.seed);
  const bool gathers_colour = request.type == RayType::kIntegrate || request.type == RayType::kSegment;
  if (gathers_colour && sampling.shade) tables.send_reflectance(sampling_towards_eye);
  if (!bricks) return batches.submit(rays, setup, std::move(lines));
  if (shared) share_anew();
  BrickRun run;
  run.of = {.of = wire::RaysOf::kTrace, .trace = trace_header(request, 0)};
  if (deposits) {
    run.needs.light = LightUse::kLeft;
    run.take_ledger = [](const wire::LightingLedger&) {};
  } else if (gathers_colour && sampled.irradiance) {
    run.needs.light = LightUse::kSeen;
  }
  return batches.submit(rays, setup, std::move(lines), [&](std::span<const EncodedRays> parts) {
    return deposits ? deposit_in_bricks(parts, run) : trace_in_bricks(parts, run);
  });
}

Ticket Board::submit(std::span<const HostRay> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->submit(std::span(&rays, 1), request, {});
}

Ticket Board::submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request) {
  const auto lock = state_->begin();
  return state_->submit(rays, request, {});
}

Ticket Board::submit(std::span<const Polyline> lines) {
  const auto lock = state_->begin();
  const LoadedVolume& volume = state_->loaded("submit()");
  std::vector<HostRay> legs;
  std::vector<std::size_t> legs_of;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Polyline& line = lines[i];
    check(line, i, volume.dims);
    for (std::size_t p = 1; p < line.points.size(); ++p) {
      legs.push_back(ray_between(line.id, line.points[p - 1], line.points[p]));
    }
    legs_of.push_back(line.points.size() - 1);
  }
  const std::span<const HostRay> all(legs);
  return state_->submit(std::span(&all, 1), {.type = RayType::kSegment}, std::move(legs_of));
}

RayBatch Board::receive(Ticket ticket, Picoseconds deadline) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.receive(ticket, deadline);
}

BatchReport Board::receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.receive(ticket, rays, deadline);
}

std::vector<RayBatch> Board::poll() {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.poll();
}

bool Board::cancel(Ticket ticket) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.cancel(ticket);
}

int Board::descriptor(Ticket ticket) {
  const auto lock = state_->begin();
  state_->need_batches();
  return state_->batches.descriptor(ticket).release();
}

std::future<RayBatch> Board::future(Ticket ticket) {
  {
    const auto lock = state_->begin();
    state_->batches.check(ticket);
  }
  return std::async(std::launch::deferred, [weak = std::weak_ptr(state_), ticket] {
    const auto state = weak.lock();
    if (!state) throw DeviceLost("the board is lost: the application has closed it", Loss::kClosed);
    const auto lock = state->begin();
    state->need_batches();
    return state->batches.receive(ticket, kNoDeadline);
  });
}

void Board::set_time_limit(Picoseconds limit) {
  const auto lock = state_->begin();
  state_->time_limit = limit;
}

}  // namespace gicube
