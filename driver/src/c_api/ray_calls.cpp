// Rays of the caller's.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "fields.h"

namespace gicube::c_api {
namespace {

// The C records are the C++ ones byte by byte, so that rays cross without a copy.
template <typename Record, typename Ray>
constexpr bool kSameLayout = std::is_standard_layout_v<Ray> && sizeof(Record) == sizeof(Ray) &&
                             alignof(Record) == alignof(Ray);
static_assert(kSameLayout<gicube_host_ray, HostRay>);
static_assert(offsetof(gicube_host_ray, id) == offsetof(HostRay, id));
static_assert(offsetof(gicube_host_ray, position) == offsetof(HostRay, position));
static_assert(offsetof(gicube_host_ray, direction) == offsetof(HostRay, direction));
static_assert(offsetof(gicube_host_ray, length) == offsetof(HostRay, length));
static_assert(offsetof(gicube_host_ray, energy) == offsetof(HostRay, energy));
static_assert(kSameLayout<gicube_traced_ray, TracedRay>);
static_assert(offsetof(gicube_traced_ray, id) == offsetof(TracedRay, id));
static_assert(offsetof(gicube_traced_ray, position) == offsetof(TracedRay, position));
static_assert(offsetof(gicube_traced_ray, direction) == offsetof(TracedRay, direction));
static_assert(offsetof(gicube_traced_ray, colour) == offsetof(TracedRay, colour));
static_assert(offsetof(gicube_traced_ray, opacity) == offsetof(TracedRay, opacity));
static_assert(offsetof(gicube_traced_ray, integral) == offsetof(TracedRay, integral));
static_assert(sizeof(Vec3) == 3 * sizeof(double) && std::is_standard_layout_v<Vec3>);

std::span<const HostRay> to_rays(const gicube_host_ray* rays, std::size_t count) {
  return {reinterpret_cast<const HostRay*>(rays), count};
}

RayRequest to_request(const gicube_ray_request* given) {
  return read_optional<gicube_ray_request, RayRequest>("request", given);
}

// Remembers the ticket of a batch of which no rays come back.
void note(gicube_board& handle, const RayRequest& request, std::uint32_t ticket) {
  if (request.type != RayType::kDeposit && request.type != RayType::kBackproject) return;
  const std::scoped_lock lock(handle.mutex);
  handle.deposits.insert(ticket);
}

// The caller need not have memory for rays of a deposit.
BatchReport receive(gicube_board& handle, Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline) {
  bool deposit = false;
  {
    const std::scoped_lock lock(handle.mutex);
    deposit = handle.deposits.contains(ticket.id);
  }
  if (!deposit) return handle.board.receive(ticket, rays, deadline);
  BatchReport report = handle.board.receive(ticket, deadline);
  const std::scoped_lock lock(handle.mutex);
  handle.deposits.erase(ticket.id);
  return report;
}

void write_report(gicube_batch_report* out, const BatchReport& batch, std::size_t rays) {
  if (out == nullptr) return;
  gicube_batch_report record{};
  record.ticket = batch.ticket.id;
  record.completed_ps = batch.completed;
  record.rays = rays;
  record.cancelled = batch.cancelled;
  record.deposited = batch.lighting.has_value();
  record.lighting = to_c(batch.lighting.value_or(LightingReport{}));
  record.backprojected = batch.deposits.has_value();
  const DepositReport left = batch.deposits.value_or(DepositReport{});
  record.deposits = {left.rays, left.samples, left.kept, left.clipped, left.overflowed, left.unit};
  write_record("report", out, record);
}

// Of a batch that gicube_poll() has told of. False if it has not.
bool receive_arrived(gicube_board& handle, std::uint32_t ticket, gicube_traced_ray* rays, std::size_t count,
                     gicube_batch_report* report) {
  const std::scoped_lock lock(handle.mutex);
  const auto found = handle.arrived.find(ticket);
  if (found == handle.arrived.end()) return false;
  const RayBatch& batch = found->second;
  if (!batch.lighting && !batch.deposits && !batch.cancelled) check_count("count", count, batch.rays.size());
  write_report(report, batch, batch.rays.size());
  const auto* from = reinterpret_cast<const gicube_traced_ray*>(batch.rays.data());
  if (!batch.rays.empty()) std::copy(from, from + batch.rays.size(), rays);
  std::erase(handle.announce, ticket);
  handle.deposits.erase(ticket);
  handle.arrived.erase(found);
  return true;
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

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
    const gicube::RayRequest asked = to_request(request);
    *ticket = handle.board.submit(to_rays(rays, count), asked).id;
    note(handle, asked, *ticket);
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
      checked(("spans[" + std::to_string(i) + "].rays").c_str(), spans[i].rays, spans[i].count);
      parts.push_back(to_rays(spans[i].rays, spans[i].count));
    }
    const gicube::RayRequest asked = to_request(request);
    *ticket = handle.board.submit(parts, asked).id;
    note(handle, asked, *ticket);
  });
}

gicube_status gicube_submit_polylines(gicube_board* board, const gicube_polyline* lines, size_t count,
                                      uint32_t* ticket) {
  return call([&] {
    checked("ticket", ticket) = 0;
    gicube_board& handle = checked_board(board);
    checked("lines", lines, count);
    std::vector<gicube::Polyline> all;
    for (std::size_t i = 0; i < count; ++i) {
      const gicube_polyline& line = lines[i];
      checked(("lines[" + std::to_string(i) + "].points").c_str(), reinterpret_cast<const gicube::Vec3*>(line.points),
              line.point_count);
      all.push_back({line.id, {reinterpret_cast<const gicube::Vec3*>(line.points), line.point_count}});
    }
    *ticket = handle.board.submit(std::span<const gicube::Polyline>(all)).id;
  });
}

gicube_status gicube_receive(gicube_board* board, uint32_t ticket, uint64_t deadline_ps, gicube_traced_ray* rays,
                             size_t count, gicube_batch_report* report) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    checked("rays", rays, count);
    if (report != nullptr) check_size<gicube_batch_report>("report", report->size, sizeof *report);
    if (receive_arrived(handle, ticket, rays, count, report)) return;
    const gicube::BatchReport batch =
        receive(handle, {ticket}, std::span(reinterpret_cast<gicube::TracedRay*>(rays), count), deadline_ps);
    write_report(report, batch, batch.cancelled || batch.lighting || batch.deposits ? 0 : count);
  });
}

gicube_status gicube_poll(gicube_board* board, gicube_batch_report* report) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    check_size<gicube_batch_report>("report", checked("report", report).size, sizeof *report);
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
}
