// The caller's rays, and light between pairs of elements.
#include <algorithm>
#include <cstddef>
#include <cstring>

#include "call.h"
#include "transport/event.h"

namespace gicube::c_api {
namespace {

// The C records have the bytes of the C++ ones (fields.h), so rays are passed without a copy.
static_assert(sizeof(Vec3) == 3 * sizeof(double) && std::is_standard_layout_v<Vec3>);

std::span<const HostRay> to_rays(const gicube_host_ray* rays, std::size_t count) {
  return {reinterpret_cast<const HostRay*>(rays), count};
}

bool comes_back(const BatchReport& batch) { return !batch.lighting && !batch.deposits && !batch.cancelled; }

void write_report(gicube_batch_report* out, const BatchReport& batch, std::size_t rays) {
  if (out == nullptr) return;
  const LightingReport lighting = batch.lighting.value_or(LightingReport{});
  auto record = to_record<gicube_batch_report>(batch);
  record.ticket = batch.ticket.id;
  record.rays = rays;
  record.deposited = batch.lighting.has_value();
  record.lighting = to_record<gicube_batch_lighting>(lighting);
  record.lighting.size = sizeof record.lighting;
  record.lighting.warnings = static_cast<std::uint32_t>(lighting.warnings.size());
  std::ranges::copy(lighting.escaped_by_face, record.escaped_by_face);
  record.backprojected = batch.deposits.has_value();
  record.deposits = to_record<gicube_deposit_report>(batch.deposits.value_or(DepositReport{}));
  write_record("report", out, record);
}

// Turns what each leg of a batch of lines gathered into the sums up to the leg's end.
void add_up_legs(gicube_board& handle, std::uint32_t ticket, std::span<gicube_traced_ray> rays) {
  const std::scoped_lock lock(handle.mutex);
  const auto found = handle.legs.find(ticket);
  if (found == handle.legs.end()) return;
  for (const std::size_t legs : found->second) {
    for (std::size_t i = 1; i < std::min(legs, rays.size()); ++i) {
      const double seen = 1 - rays[i - 1].opacity;
      for (std::size_t c = 0; c < 3; ++c) rays[i].colour[c] = rays[i - 1].colour[c] + seen * rays[i].colour[c];
      rays[i].opacity = rays[i - 1].opacity + seen * rays[i].opacity;
    }
    rays = rays.subspan(std::min(legs, rays.size()));
  }
  handle.legs.erase(found);
}

// Receives a batch that gicube_poll() has reported. False if it has not reported it.
bool receive_arrived(gicube_board& handle, std::uint32_t ticket, gicube_traced_ray* rays, std::size_t count,
                     gicube_batch_report* report) {
  const std::scoped_lock lock(handle.mutex);
  const auto found = handle.arrived.find(ticket);
  if (found == handle.arrived.end()) return false;
  const RayBatch& batch = found->second;
  if (comes_back(batch)) check_count("count", count, batch.rays.size());
  write_report(report, batch, batch.rays.size());
  const auto* from = reinterpret_cast<const gicube_traced_ray*>(batch.rays.data());
  if (!batch.rays.empty()) std::copy(from, from + batch.rays.size(), rays);
  std::erase(handle.announce, ticket);
  handle.arrived.erase(found);
  return true;
}

RayRequest to_request(gicube_board& handle, const gicube_ray_request* given) {
  gicube_ray_request record{};
  RayRequest request;
  if (given != nullptr) request = read_fields<RayRequest>("request", given, record);
  if (record.sampled_as != nullptr) {
    request.sampling = sampling_of(to_view(record.sampled_as, "request.sampled_as"));
  } else {
    const std::scoped_lock lock(handle.mutex);
    request.sampling = handle.sampling;
  }
  return request;
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_ray_request_init(gicube_ray_request* request, size_t size) {
  return init<gicube::RayRequest>("request", request, size);
}

gicube_status gicube_pair_request_init(gicube_pair_request* request, size_t size) {
  return init<gicube::PairRequest>("request", request, size);
}

gicube_status gicube_batch_report_init(gicube_batch_report* report, size_t size) {
  return call([&] {
    gicube_batch_report record{};
    record.lighting.size = sizeof record.lighting;
    write_record("report", report, size, record);
  });
}

gicube_status gicube_ray_between(uint32_t id, const double from[3], const double to[3], gicube_host_ray* ray) {
  return call([&] {
    checked("from", from);
    checked("to", to);
    const gicube::HostRay between = gicube::ray_between(id, {from[0], from[1], from[2]}, {to[0], to[1], to[2]});
    std::memcpy(&checked("ray", ray), &between, sizeof between);
    ray->reserved = 0;
  });
}

gicube_status gicube_submit(gicube_board* board, const gicube_host_ray* rays, size_t count,
                            const gicube_ray_request* request, uint32_t* ticket) {
  return call([&] {
    checked("ticket", ticket) = 0;
    gicube_board& handle = checked_board(board);
    checked("rays", rays, count);
    *ticket = handle.board.submit(to_rays(rays, count), to_request(handle, request)).id;
  });
}

gicube_status gicube_submit_gather(gicube_board* board, const gicube_ray_span* spans, size_t span_count,
                                   const gicube_ray_request* request, uint32_t* ticket) {
  return call([&] {
    checked("ticket", ticket) = 0;
    gicube_board& handle = checked_board(board);
    checked("spans", spans, span_count);
    std::vector<std::span<const gicube::HostRay>> parts;
    for (std::size_t i = 0; i < span_count; ++i) {
      checked("spans[" + std::to_string(i) + "].rays", spans[i].rays, spans[i].count);
      parts.push_back(to_rays(spans[i].rays, spans[i].count));
    }
    *ticket = handle.board.submit(parts, to_request(handle, request)).id;
  });
}

gicube_status gicube_submit_polylines(gicube_board* board, const gicube_polyline* lines, size_t count,
                                      uint32_t* ticket) {
  return call([&] {
    checked("ticket", ticket) = 0;
    gicube_board& handle = checked_board(board);
    checked("lines", lines, count);
    std::vector<gicube::HostRay> rays;
    std::vector<std::size_t> legs;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string name = "lines[" + std::to_string(i) + "].points";
      const auto* points = checked(name, reinterpret_cast<const gicube::Vec3*>(lines[i].points), lines[i].point_count);
      gicube::expect(lines[i].point_count >= 2, name, "at least 2", lines[i].point_count);
      legs.push_back(lines[i].point_count - 1);
      for (std::size_t p = 1; p < lines[i].point_count; ++p) {
        rays.push_back(gicube::ray_between(lines[i].id, points[p - 1], points[p]));
      }
    }
    gicube::RayRequest request = to_request(handle, nullptr);
    request.type = gicube::RayType::kSegment;
    *ticket = handle.board.submit(rays, request).id;
    const std::scoped_lock lock(handle.mutex);
    handle.legs[*ticket] = std::move(legs);
  });
}

gicube_status gicube_receive(gicube_board* board, uint32_t ticket, uint64_t deadline_ps, gicube_traced_ray* rays,
                             size_t count, gicube_batch_report* report) {
  return on_board(board, [&](gicube_board& handle) {
    checked("rays", rays, count);
    check_optional("report", report);
    if (!receive_arrived(handle, ticket, rays, count, report)) {
      const gicube::BatchReport batch =
          handle.board.receive({ticket}, {reinterpret_cast<gicube::TracedRay*>(rays), count}, deadline_ps);
      write_report(report, batch, comes_back(batch) ? count : 0);
    }
    add_up_legs(handle, ticket, {rays, count});
  });
}

gicube_status gicube_poll(gicube_board* board, gicube_batch_report* report) {
  return on_board(board, [&](gicube_board& handle) {
    check_size("report", report, checked("report", report).size);
    std::vector<gicube::RayBatch> batches = handle.board.poll();
    const std::scoped_lock lock(handle.mutex);
    for (gicube::RayBatch& batch : batches) {
      handle.announce.push_back(batch.ticket.id);
      handle.arrived.insert_or_assign(batch.ticket.id, std::move(batch));
    }
    if (handle.announce.empty()) return write_report(report, {}, 0);
    const gicube::RayBatch& first = handle.arrived.at(handle.announce.front());
    write_report(report, first, first.rays.size());
    handle.announce.erase(handle.announce.begin());
  });
}

gicube_status gicube_batch_descriptor(gicube_board* board, uint32_t ticket, int* descriptor) {
  return call([&] {
    checked("descriptor", descriptor) = -1;
    gicube_board& handle = checked_board(board);
    {
      const std::scoped_lock lock(handle.mutex);
      if (handle.arrived.contains(ticket)) {
        gicube::Event arrived;
        gicube::Fd readable = arrived.descriptor();
        *descriptor = readable.release();
        return;
      }
    }
    *descriptor = handle.board.descriptor({ticket});
  });
}

gicube_status gicube_cancel(gicube_board* board, uint32_t ticket, int32_t* cancelled) {
  return call([&] {
    checked("cancelled", cancelled) = 0;
    gicube_board& handle = checked_board(board);
    {
      const std::scoped_lock lock(handle.mutex);
      if (handle.arrived.contains(ticket)) return;
    }
    *cancelled = handle.board.cancel({ticket});
  });
}

gicube_status gicube_pair_factors(gicube_board* board, const gicube_element* elements, size_t element_count,
                                  const gicube_element_pair* pairs, size_t pair_count,
                                  const gicube_pair_request* request, gicube_progress progress, void* user,
                                  gicube_pair_factor* factors, size_t count) {
  return on_board(board, [&](gicube_board& handle) {
    const auto all = from_records<gicube::Element>("elements", elements, element_count);
    const auto between = from_records<gicube::ElementPair>("pairs", pairs, pair_count);
    check_count("count", count, pair_count);
    checked("factors", factors, count);
    const auto how = read_optional<gicube::PairRequest>("request", request);
    for (const gicube::PairFactor& factor : handle.board.pair_factors(all, between, how, to_progress(progress, user))) {
      *factors++ = to_record<gicube_pair_factor>(factor);
    }
  });
}
}
