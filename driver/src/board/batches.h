// The ray batches under way: those that were submitted and not received yet.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "answer_watch.h"
#include "device.h"
#include "encode/host_ray.h"
#include "gicube/ray.h"
#include "gicube/wire/command.h"

namespace gicube {

// Adds a ledger of the board, which counts units of the words, to a report in the application's unit: each unit is
// worth `report.unit`. `word`: which one of three irradiance words.
inline void add(const wire::LightingLedger& ledger, LightingReport& report, std::size_t word = 0) {
  const auto energy = [unit = report.unit](std::uint64_t units) { return static_cast<double>(units) * unit; };
  const auto add_to = [&](auto& energies) {
    energies.emitted += energy(ledger.emitted);
    energies.deposited += energy(ledger.deposited);
    energies.escaped += energy(ledger.escaped);
    energies.scattered_away += energy(ledger.scattered_away);
    energies.given_up += energy(ledger.given_up);
    energies.clipped += energy(ledger.clipped);
  };
  add_to(report);
  if (!report.colours.empty()) add_to(report.colours[word]);
  if (word == 0) report.rays += ledger.rays;
  for (std::size_t face = 0; face < wire::kFaces; ++face) {
    report.escaped_by_face[face] += energy(ledger.escaped_by_face[face]);
  }
}

inline void add(const wire::DepositLedger& ledger, DepositReport& report) {
  report.rays += ledger.rays;
  report.samples += ledger.samples;
  report.kept += static_cast<double>(ledger.kept) * report.unit;
  report.clipped += static_cast<double>(ledger.clipped) * report.unit;
  report.overflowed += ledger.overflowed;
}

// A trace command.
struct EncodedRays {
  wire::Payload encoded;
  std::size_t rays = 0;
};

class Batches {
 public:
  Batches(Device& device, const OpenOptions& options)
      : device_(device), max_rays_(options.max_rays), back_pressure_(options.back_pressure) {}

  // Submits rays that passed their checks. Throws WouldBlock.
  Ticket submit(std::span<const std::span<const HostRay>> rays, const RaySetup& setup);
  // Traces a batch that is complete on return: `trace` executes the commands, and returns what each would return.
  using TraceAll = std::function<std::vector<CommandResult>(std::span<const EncodedRays>)>;
  Ticket submit(std::span<const std::span<const HostRay>> rays, const RaySetup& setup, const TraceAll& trace);
  // Throw BadArgument (ticket), DeadlinePassed; Rejected or Unsupported if the board refused the batch, which is gone
  // then.
  RayBatch receive(Ticket ticket, Picoseconds deadline);
  BatchReport receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline);
  // Throws Rejected or Unsupported for one batch that the board refused, which is gone then; the others stay.
  std::vector<RayBatch> poll();
  bool cancel(Ticket ticket);
  // Board::descriptor(). Throws BadArgument (ticket).
  Fd descriptor(Ticket ticket);
  // Throws BadArgument (ticket).
  void check(Ticket ticket) { find(ticket); }

  bool empty() const { return batches_.empty(); }
  // Lists everything but the device, the limits, the descriptors and the warnings. Throws CheckpointFault.
  void state(Archive& archive);
  // For a new board: sends all batches that have not come back again, in order. Before each it calls
  // `set_sampling(view, towards_eye)` with the arguments of its submission.
  void send_again(const std::function<void(const View&, Vec3)>& set_sampling);

 private:
  struct Batch;
  void state(Archive& archive, Batch& batch) const;

  struct Part {
    std::uint32_t command = 0;
    std::size_t rays = 0;
    wire::Payload encoded;      // until the result has come
    std::vector<double> units;  // kIntegral: of one unit of each ray's sum
    std::optional<CommandResult> result;
  };
  struct Batch {
    Picoseconds completed = 0;
    std::size_t rays = 0;
    RayType type = RayType::kIntegrate;
    double energy_unit = 0;
    std::size_t irradiance_words = 1;
    View sampling;
    Vec3 towards_eye;
    std::vector<std::string> warnings;
    std::vector<Part> parts;
    std::shared_ptr<Event> worked_out;  // after descriptor()

    bool complete() const {
      return std::ranges::all_of(parts, [](const Part& part) { return part.result.has_value(); });
    }
    bool comes_back() const { return type != RayType::kDeposit && type != RayType::kBackproject; }
  };
  using Entry = std::map<std::uint32_t, Batch>::iterator;

  Batch begin(std::span<const std::span<const HostRay>> rays, const RaySetup& setup) const;
  std::uint32_t next_ticket();
  std::size_t max_rays_of_command() const;
  Entry find(Ticket ticket);
  void make_room(std::size_t rays);
  // Drops a batch of which only a part was sent. Results that still come are ignored.
  void drop(std::uint32_t ticket);
  void collect(Batch& batch);
  void complete(Batch& batch, Picoseconds deadline);
  // Removes a complete batch from the list and decodes its rays into `rays`, which has their number.
  BatchReport release(Entry entry, std::span<TracedRay> rays);
  RayBatch release(Entry entry);

  Device& device_;
  const std::size_t max_rays_;
  const BackPressure back_pressure_;
  std::uint32_t last_ticket_ = 0;
  std::size_t rays_under_way_ = 0;
  std::map<std::uint32_t, Batch> batches_;
  AnswerWatch watch_;
};

}  // namespace gicube
