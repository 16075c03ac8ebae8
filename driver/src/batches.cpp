#include "batches.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "lighting_ledger.h"
#include "link_error.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysPerCommand = 4096;  // chosen: 128 KB, so that the board's work and the bus overlap

// Walks through rays that lie in several places.
class Gather {
 public:
  explicit Gather(std::span<const std::span<const HostRay>> parts) : parts_(parts) {}

  const HostRay& next() {
    while (at_ == parts_.front().size()) {
      parts_ = parts_.subspan(1);
      at_ = 0;
    }
    return parts_.front()[at_++];
  }

 private:
  std::span<const std::span<const HostRay>> parts_;
  std::size_t at_ = 0;
};

std::vector<std::uint8_t> trace_command(Gather& rays, std::size_t count, const RaySetup& setup) {
  std::vector<std::uint8_t> bytes(wire::kTraceHeaderBytes + count * wire::kRayBytes);
  const std::span all(bytes);
  wire::encode(trace_header(setup.request, count), all.first<wire::kTraceHeaderBytes>());
  for (std::size_t i = 0; i < count; ++i) {
    wire::encode(to_wire(rays.next(), setup),
                 all.subspan(wire::kTraceHeaderBytes + i * wire::kRayBytes).first<wire::kRayBytes>());
  }
  return bytes;
}

bool refused(const CommandResult& result) {
  return result.error != wire::ErrorCode::kNone && result.error != wire::ErrorCode::kCancelled;
}

}  // namespace

bool Batches::Batch::complete() const {
  return std::all_of(parts.begin(), parts.end(), [](const Part& part) { return part.result.has_value(); });
}

Ticket Batches::submit(std::span<const std::span<const HostRay>> rays, const RaySetup& setup,
                       std::vector<std::size_t> lines) {
  Batch batch;
  for (const auto& part : rays) batch.rays += part.size();
  if (limits_.back_pressure == BackPressure::kThrow) make_room(batch.rays);
  const std::size_t limit = (device_.agreed().max_payload_bytes - wire::kTraceHeaderBytes) / wire::kRayBytes;
  const std::size_t most = std::min(kRaysPerCommand, limit);
  batch.lines = std::move(lines);
  batch.deposits = setup.request.type == RayType::kDeposit;
  batch.energy_unit = setup.energy_unit;
  batch.sampling = setup.sampling;
  batch.towards_eye = setup.towards_eye;
  do {
    ++last_ticket_;
  } while (last_ticket_ == 0 || batches_.contains(last_ticket_));
  const std::uint32_t ticket = last_ticket_;
  Batch& kept = batches_.emplace(ticket, std::move(batch)).first->second;
  Gather from(rays);
  for (std::size_t left = kept.rays; left > 0;) {
    const std::size_t count = std::min(left, most);
    if (limits_.back_pressure == BackPressure::kWait) make_room(count);
    auto encoded = std::make_shared<const std::vector<std::uint8_t>>(trace_command(from, count, setup));
    const std::uint32_t command = device_.command(encoded);
    kept.parts.push_back({command, count, std::move(encoded), std::nullopt});
    rays_under_way_ += count;
    left -= count;
  }
  kept.completed = device_.clock().now();
  return {ticket};
}

// Sees to it that `rays` more may be under way.
void Batches::make_room(std::size_t rays) {
  if (rays_under_way_ + rays <= limits_.most_rays) return;
  if (limits_.back_pressure == BackPressure::kThrow) {
    device_.poll();
    for (auto& [ticket, batch] : batches_) collect(batch);
    if (rays_under_way_ + rays <= limits_.most_rays) return;
    throw WouldBlock("rays: expected at most " + std::to_string(limits_.most_rays) + " under way (most_rays), got " +
                     std::to_string(rays) + " more to " + std::to_string(rays_under_way_));
  }
  for (auto& [ticket, batch] : batches_) {
    for (Part& part : batch.parts) {
      if (part.result) continue;
      part.result = device_.finish(part.command, {});
      collect(batch);
      if (rays_under_way_ + rays <= limits_.most_rays) return;
    }
  }
}

// Takes the results that have come.
void Batches::collect(Batch& batch) {
  for (Part& part : batch.parts) {
    if (!part.result) part.result = device_.take(part.command);
    if (!part.result || !part.encoded) continue;
    part.encoded.reset();
    rays_under_way_ -= part.rays;
    batch.completed = std::max(batch.completed, part.result->time_ps);
  }
}

Batches::Entry Batches::find(Ticket ticket) {
  const auto entry = batches_.find(ticket.id);
  if (entry == batches_.end()) {
    throw BadArgument("ticket", "one that was submitted and not received yet", std::to_string(ticket.id));
  }
  return entry;
}

void Batches::complete(Batch& batch, Picoseconds deadline) {
  collect(batch);
  // The last part completes last, so that there is one wait; were it otherwise, the others would be waited for too.
  for (auto part = batch.parts.rbegin(); part != batch.parts.rend(); ++part) {
    if (part->result) continue;
    part->result = device_.finish(part->command, {}, deadline);
    collect(batch);
  }
  if (batch.completed > deadline) {  // the results were known before
    device_.clock().wait_until(deadline);
    throw DeadlinePassed("the batch arrives after its deadline");
  }
  device_.clock().wait_until(batch.completed);
}

RayBatch Batches::receive(Ticket ticket, Picoseconds deadline) {
  const Entry entry = find(ticket);
  complete(entry->second, deadline);
  return release(entry);
}

BatchReport Batches::receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline) {
  const Entry entry = find(ticket);
  if (rays.size() != entry->second.rays) {
    throw BadArgument("rays", std::to_string(entry->second.rays) + " of them, as were submitted",
                      std::to_string(rays.size()));
  }
  complete(entry->second, deadline);
  return release(entry, rays);
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
  const auto bad = std::find_if(arrived.begin(), arrived.end(), [](Entry entry) {
    return std::any_of(entry->second.parts.begin(), entry->second.parts.end(),
                       [](const Part& part) { return refused(*part.result); });
  });
  if (bad != arrived.end()) release(*bad, {});
  std::vector<RayBatch> batches;
  for (const Entry entry : arrived) batches.push_back(release(entry));
  return batches;
}

bool Batches::cancel(Ticket ticket) {
  Batch& batch = find(ticket)->second;
  if (batch.deposits) throw Unsupported("a batch of type kDeposit can't be cancelled: its energy may be spent");
  bool any = false;
  // From the end: the part in work, if any, is found last.
  for (auto part = batch.parts.rbegin(); part != batch.parts.rend(); ++part) {
    if (!part->result && device_.cancel(part->command)) any = true;
  }
  return any;
}

void Batches::send_again(const std::function<void(const View&, Vec3)>& set_sampling) {
  for (auto& [ticket, batch] : batches_) {
    if (batch.complete()) continue;
    set_sampling(batch.sampling, batch.towards_eye);
    for (Part& part : batch.parts) {
      if (!part.result) part.command = device_.command(part.encoded);
    }
  }
}

RayBatch Batches::release(Entry entry) {
  const bool cancelled = std::any_of(entry->second.parts.begin(), entry->second.parts.end(), [](const Part& part) {
    return part.result->error == wire::ErrorCode::kCancelled;
  });
  RayBatch batch;
  if (!cancelled && !entry->second.deposits) batch.rays.resize(entry->second.rays);
  static_cast<BatchReport&>(batch) = release(entry, batch.rays);
  return batch;
}

BatchReport Batches::release(Entry entry, std::span<TracedRay> rays) {
  const Batch batch = std::move(entry->second);
  BatchReport report{{entry->first}, batch.completed, false, std::nullopt};
  batches_.erase(entry);
  if (batch.deposits) report.lighting.emplace().unit = batch.energy_unit;
  for (const Part& part : batch.parts) {
    if (refused(*part.result)) throw_error(part.result->error, error_text(part.result->payload));
    if (part.result->error == wire::ErrorCode::kCancelled) report.cancelled = true;
  }
  if (report.cancelled) return report;
  std::size_t at = 0;
  for (const Part& part : batch.parts) {
    const std::span<const std::uint8_t> bytes = part.result->payload;
    if (bytes.size() != (batch.deposits ? wire::kLightingLedgerBytes : part.rays * wire::kRayBytes)) {
      device_.give_up("the board returned " + std::to_string(bytes.size()) + " bytes for " + std::to_string(part.rays) +
                      " rays");
    }
    if (batch.deposits) {
      add(wire::decode_lighting_ledger(bytes.first<wire::kLightingLedgerBytes>()), *report.lighting);
      continue;
    }
    for (std::size_t i = 0; i < part.rays; ++i) {
      rays[at++] = from_wire(wire::decode_ray(bytes.subspan(i * wire::kRayBytes).first<wire::kRayBytes>()));
    }
  }
  for (const std::size_t legs : batch.lines) {
    add_up(rays.first(legs));
    rays = rays.subspan(legs);
  }
  return report;
}

}  // namespace gicube
