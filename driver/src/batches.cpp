#include "batches.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "link_error.h"
#include "upload/host_ray.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysPerCommand = 4096;  // chosen: 128 KB, so that the board's work and the bus overlap

std::vector<std::uint8_t> trace_command(std::span<const HostRay> rays) {
  std::vector<std::uint8_t> bytes(wire::kTraceHeaderBytes + rays.size() * wire::kRayBytes);
  wire::store(std::span(bytes), 0, static_cast<std::uint32_t>(wire::Opcode::kTrace));
  wire::store(std::span(bytes), 4, static_cast<std::uint32_t>(rays.size()));
  std::size_t at = wire::kTraceHeaderBytes;
  for (const HostRay& ray : rays) {
    wire::encode(to_wire(ray), std::span(bytes).subspan(at).first<wire::kRayBytes>());
    at += wire::kRayBytes;
  }
  return bytes;
}

}  // namespace

bool Batches::Batch::complete() const {
  return std::all_of(parts.begin(), parts.end(), [](const Part& part) { return part.result.has_value(); });
}

Ticket Batches::submit(std::span<const HostRay> rays) {
  const std::size_t limit = (device_.agreed().max_payload_bytes - wire::kTraceHeaderBytes) / wire::kRayBytes;
  const std::size_t most = std::min(kRaysPerCommand, limit);
  Batch batch;
  batch.completed = device_.clock().now();
  while (!rays.empty()) {
    const auto part = rays.first(std::min(rays.size(), most));
    batch.parts.push_back({device_.command(trace_command(part)), part.size(), std::nullopt});
    rays = rays.subspan(part.size());
  }
  do {
    ++last_ticket_;
  } while (last_ticket_ == 0 || batches_.contains(last_ticket_));
  batches_.emplace(last_ticket_, std::move(batch));
  return {last_ticket_};
}

// Takes the results that have come.
void Batches::collect(Batch& batch) {
  for (Part& part : batch.parts) {
    if (!part.result) part.result = device_.take(part.command);
    if (part.result) batch.completed = std::max(batch.completed, part.result->time_ps);
  }
}

RayBatch Batches::receive(Ticket ticket) {
  const auto entry = batches_.find(ticket.id);
  if (entry == batches_.end()) {
    throw BadArgument("ticket", "one that was submitted and not received yet", std::to_string(ticket.id));
  }
  Batch& batch = entry->second;
  collect(batch);
  // The last part completes last, so that there is one wait; were it otherwise, the others would be waited for too.
  for (auto part = batch.parts.rbegin(); part != batch.parts.rend(); ++part) {
    if (part->result) continue;
    part->result = device_.finish(part->command, {});
    collect(batch);
  }
  collect(batch);
  device_.clock().wait_until(batch.completed);
  return release(entry);
}

std::vector<RayBatch> Batches::poll() {
  device_.poll();
  std::vector<Entry> arrived;
  for (Entry entry = batches_.begin(); entry != batches_.end(); ++entry) {
    collect(entry->second);
    if (entry->second.complete() && entry->second.completed <= device_.clock().now()) arrived.push_back(entry);
  }
  std::stable_sort(arrived.begin(), arrived.end(),
                   [](Entry a, Entry b) { return a->second.completed < b->second.completed; });
  // A refused batch comes first: what it throws must not take the rays of the others along.
  const auto refused = std::find_if(arrived.begin(), arrived.end(), [](Entry entry) {
    return std::any_of(entry->second.parts.begin(), entry->second.parts.end(),
                       [](const Part& part) { return part.result->error != wire::ErrorCode::kNone; });
  });
  if (refused != arrived.end()) release(*refused);
  std::vector<RayBatch> batches;
  for (const Entry entry : arrived) batches.push_back(release(entry));
  return batches;
}

// Takes a complete batch out of the list and decodes its rays.
RayBatch Batches::release(Entry entry) {
  const Batch batch = std::move(entry->second);
  RayBatch rays{{entry->first}, batch.completed, {}};
  batches_.erase(entry);
  for (const Part& part : batch.parts) {
    const CommandResult& result = *part.result;
    if (result.error != wire::ErrorCode::kNone) throw_error(result.error, error_text(result.payload));
    if (result.payload.size() != part.rays * wire::kRayBytes) {
      device_.give_up("the board returned " + std::to_string(result.payload.size()) + " bytes for " +
                      std::to_string(part.rays) + " rays");
    }
    for (std::size_t i = 0; i < part.rays; ++i) {
      const auto bytes = std::span(result.payload).subspan(i * wire::kRayBytes).first<wire::kRayBytes>();
      rays.rays.push_back(from_wire(wire::decode_ray(bytes)));
    }
  }
  return rays;
}

}  // namespace gicube
