#include "batches.h"

#include <fmt/format.h>

#include <algorithm>
#include <ranges>
#include <utility>

#include "board/deadline.h"
#include "encode/argument.h"
#include "gicube/wire/ray.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysPerCommand = 4096;  // chosen: 128 KB, so that the board's work and the bus overlap

struct TraceCommand {
  std::vector<std::uint8_t> bytes;
  std::size_t rays = 0;
  std::vector<double> units;  // kIntegral
};

// Makes a command for at most `max_rays` rays, from `ray` on. kBackproject: for fewer if a sum could otherwise move
// further than one command may, but at least one.
TraceCommand trace_command(auto& ray, std::size_t max_rays, const RaySetup& setup) {
  constexpr std::uint64_t kMaxMoved = std::uint64_t{1} << 34;  // command.h
  TraceCommand command;
  command.bytes.resize(wire::kTraceHeaderBytes + max_rays * wire::kRayBytes);
  std::uint64_t moved = 0;
  for (; command.rays < max_rays; ++command.rays, ++ray) {
    const wire::Ray packet = to_wire(*ray, setup);
    moved += max_moved(packet, setup);
    if (moved > kMaxMoved && command.rays > 0) break;
    if (setup.request.type == RayType::kIntegral) command.units.push_back(integral_unit(*ray, setup));
    wire::encode(packet, std::span(command.bytes).subspan(wire::kTraceHeaderBytes + command.rays * wire::kRayBytes));
  }
  command.bytes.resize(wire::kTraceHeaderBytes + command.rays * wire::kRayBytes);
  wire::encode(trace_header(setup.request, command.rays), command.bytes);
  return command;
}

bool refused(const CommandResult& result) {
  return result.error != wire::ErrorCode::kNone && result.error != wire::ErrorCode::kCancelled;
}

std::size_t bytes_of_result(RayType type, std::size_t rays, std::uint16_t minor, std::size_t irradiance_words) {
  switch (type) {
    case RayType::kDeposit: return irradiance_words * wire::lighting_ledger_bytes(minor);
    case RayType::kBackproject: return wire::kDepositLedgerBytes;
    default: return rays * wire::kRayBytes;
  }
}

}  // namespace

Batches::Batch Batches::begin(std::span<const std::span<const HostRay>> rays, const RaySetup& setup) const {
  Batch batch;
  for (const auto& part : rays) batch.rays += part.size();
  batch.type = setup.request.type;
  batch.energy_unit = setup.energy_unit;
  batch.irradiance_words = setup.irradiance_words;
  batch.sampling = setup.sampling;
  batch.towards_eye = setup.towards_eye;
  batch.warnings = setup.warnings;
  return batch;
}

std::uint32_t Batches::next_ticket() {
  do {
    ++last_ticket_;
  } while (last_ticket_ == 0 || batches_.contains(last_ticket_));
  return last_ticket_;
}

std::size_t Batches::max_rays_of_command() const {
  const std::size_t limit = (device_.agreed().max_payload_bytes - wire::kTraceHeaderBytes) / wire::kRayBytes;
  return std::min(kRaysPerCommand, limit);
}

Ticket Batches::submit(std::span<const std::span<const HostRay>> rays, const RaySetup& setup) {
  Batch batch = begin(rays, setup);
  if (back_pressure_ == BackPressure::kThrow) make_room(batch.rays);
  const std::size_t max_rays = max_rays_of_command();
  const std::uint32_t ticket = next_ticket();
  Batch& kept = batches_.emplace(ticket, std::move(batch)).first->second;
  auto all = rays | std::views::join;
  auto ray = all.begin();
  try {
    for (std::size_t left = kept.rays; left > 0;) {
      const std::size_t count = std::min(left, max_rays);
      if (back_pressure_ == BackPressure::kWait) make_room(count);
      TraceCommand made = trace_command(ray, count, setup);
      auto encoded = wire::share(std::move(made.bytes));
      const std::uint32_t command = device_.command(encoded);
      kept.parts.push_back({command, made.rays, std::move(encoded), std::move(made.units), std::nullopt});
      rays_under_way_ += made.rays;
      left -= made.rays;
    }
  } catch (...) {  // the caller has no ticket and will repeat the whole call
    drop(ticket);
    throw;
  }
  kept.completed = device_.clock().now();
  return {ticket};
}

Ticket Batches::submit(std::span<const std::span<const HostRay>> rays, const RaySetup& setup, const TraceAll& trace) {
  Batch batch = begin(rays, setup);
  std::vector<EncodedRays> commands;
  auto all = rays | std::views::join;
  auto ray = all.begin();
  for (std::size_t left = batch.rays; left > 0; left -= commands.back().rays) {
    TraceCommand made = trace_command(ray, std::min(left, max_rays_of_command()), setup);
    commands.push_back({wire::share(std::move(made.bytes)), made.rays});
    batch.parts.push_back({0, made.rays, {}, std::move(made.units), std::nullopt});
  }
  std::vector<CommandResult> results = trace(commands);
  for (std::size_t i = 0; i < results.size(); ++i) batch.parts[i].result = std::move(results[i]);
  batch.completed = device_.clock().now();
  const std::uint32_t ticket = next_ticket();
  batches_.emplace(ticket, std::move(batch));
  return {ticket};
}

void Batches::drop(std::uint32_t ticket) {
  for (const Part& part : batches_.at(ticket).parts) {
    if (!part.result) device_.forget(part.command);
    if (part.encoded) rays_under_way_ -= part.rays;
  }
  batches_.erase(ticket);
}

void Batches::make_room(std::size_t rays) {
  if (rays_under_way_ + rays <= max_rays_) return;
  if (back_pressure_ == BackPressure::kThrow) {
    device_.poll();
    for (auto& [ticket, batch] : batches_) collect(batch);
    if (rays_under_way_ + rays <= max_rays_) return;
    throw WouldBlock(fmt::format("rays: expected at most {} under way (max_rays), got {} more to {}", max_rays_, rays,
                                 rays_under_way_));
  }
  for (auto& [ticket, batch] : batches_) {
    for (Part& part : batch.parts) {
      if (part.result) continue;
      part.result = device_.finish(part.command, {});
      collect(batch);
      if (rays_under_way_ + rays <= max_rays_) return;
    }
  }
}

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
  expect(entry != batches_.end(), "ticket", "a ticket that was submitted and not received yet", ticket.id);
  return entry;
}

void Batches::complete(Batch& batch, Picoseconds deadline) {
  collect(batch);
  // The last part usually completes last, so one wait is enough.
  for (Part& part : batch.parts | std::views::reverse) {
    if (part.result) continue;
    part.result = device_.finish(part.command, {}, deadline);
    collect(batch);
  }
  if (batch.completed > deadline) {  // all results had arrived before
    device_.clock().wait_until(deadline);
    throw deadline_passed(deadline);
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
  const Batch& batch = entry->second;
  const bool fits = !batch.comes_back() || rays.size() == batch.rays;
  expect(fits, "rays", fmt::format("{}, as many as were submitted", batch.rays), rays.size());
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
  std::ranges::stable_sort(arrived, {}, [](Entry entry) { return entry->second.completed; });
  // A refused batch is released first, so that its exception does not lose the rays of others.
  const auto bad = std::ranges::find_if(arrived, [](Entry entry) {
    return std::ranges::any_of(entry->second.parts, [](const Part& part) { return refused(*part.result); });
  });
  if (bad != arrived.end()) release(*bad, {});
  std::vector<RayBatch> batches;
  for (const Entry entry : arrived) batches.push_back(release(entry));
  return batches;
}

bool Batches::cancel(Ticket ticket) {
  Batch& batch = find(ticket)->second;
  if (!batch.comes_back()) {
    throw Unsupported(batch.type == RayType::kDeposit
                          ? "a batch of type kDeposit can't be cancelled: its energy may be spent"
                          : "a batch of type kBackproject can't be cancelled: it may have left something");
  }
  bool any = false;
  // Cancels from the end, so that a part that the board works on comes last.
  for (Part& part : batch.parts | std::views::reverse) {
    if (!part.result && device_.cancel(part.command)) any = true;
  }
  return any;
}

Fd Batches::descriptor(Ticket ticket) {
  Batch& batch = find(ticket)->second;
  if (!batch.worked_out) {
    auto event = std::make_shared<Event>();
    const Device::Mark mark = device_.mark();
    watch_.add(mark.link, mark.request, event);
    batch.worked_out = std::move(event);
  }
  return batch.worked_out->descriptor();
}

void Batches::send_again(const std::function<void(const View&, Vec3)>& set_sampling) {
  for (auto& [ticket, batch] : batches_) {
    if (batch.complete()) continue;
    batch.worked_out.reset();
    set_sampling(batch.sampling, batch.towards_eye);
    for (Part& part : batch.parts) {
      if (!part.result) part.command = device_.command(part.encoded);
    }
  }
}

RayBatch Batches::release(Entry entry) {
  const bool cancelled = std::ranges::any_of(
      entry->second.parts, [](const Part& part) { return part.result->error == wire::ErrorCode::kCancelled; });
  RayBatch batch;
  if (!cancelled && entry->second.comes_back()) batch.rays.resize(entry->second.rays);
  static_cast<BatchReport&>(batch) = release(entry, batch.rays);
  return batch;
}

BatchReport Batches::release(Entry entry, std::span<TracedRay> rays) {
  Batch batch = std::move(entry->second);
  BatchReport report{{entry->first}, batch.completed, false, std::nullopt, std::nullopt};
  batches_.erase(entry);
  const bool deposits = batch.type == RayType::kDeposit, backprojects = batch.type == RayType::kBackproject;
  if (deposits) report.lighting.emplace().unit = batch.energy_unit;
  const std::size_t words = batch.irradiance_words;
  if (deposits && words > 1) report.lighting->colours.resize(words);
  if (backprojects) report.deposits.emplace().unit = batch.energy_unit;
  for (const Part& part : batch.parts) {
    if (refused(*part.result)) throw_error(part.result->error, error_text(part.result->payload));
    if (part.result->error == wire::ErrorCode::kCancelled) report.cancelled = true;
  }
  if (report.cancelled) return report;
  if (deposits) report.lighting->warnings = std::move(batch.warnings);
  std::size_t at = 0;
  const std::uint16_t minor = device_.agreed().minor;
  for (const Part& part : batch.parts) {
    const std::span<const std::uint8_t> bytes = part.result->payload;
    if (bytes.size() != bytes_of_result(batch.type, part.rays, minor, words)) {
      device_.give_up(fmt::format("the board returned {} bytes for {} rays", bytes.size(), part.rays));
    }
    if (backprojects) add(wire::decode<wire::DepositLedger>(bytes), *report.deposits);
    for (std::size_t word = 0; deposits && word < words; ++word) {
      add(wire::decode_lighting_ledger(bytes.subspan(word * bytes.size() / words), minor), *report.lighting, word);
    }
    for (std::size_t i = 0; i < part.rays && batch.comes_back(); ++i) {
      const wire::Ray ray = wire::decode<wire::Ray>(bytes.subspan(i * wire::kRayBytes));
      rays[at++] = batch.type == RayType::kIntegral ? integral_from_wire(ray, part.units[i]) : from_wire(ray);
    }
  }
  return report;
}

}  // namespace gicube
