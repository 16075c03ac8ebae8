// The ray batches that are under way: what was submitted and not received yet.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "answer_watch.h"
#include "device.h"
#include "encode/host_ray.h"
#include "gicube/ray.h"
#include "gicube/wire/command.h"

namespace gicube {

// The board's accounts, in units of the words, added up in the application's: each unit is worth `report.unit`. `word`:
// of three irradiance words.
inline void add(const wire::LightingLedger& ledger, LightingReport& report, std::size_t word = 0) {
  if (word == 0) report.rays += ledger.rays;
  if (!report.colours.empty()) {
    LightEnergy& colour = report.colours[word];
    colour.emitted += static_cast<double>(ledger.emitted) * report.unit;
    colour.deposited += static_cast<double>(ledger.deposited) * report.unit;
    colour.escaped += static_cast<double>(ledger.escaped) * report.unit;
    colour.scattered_away += static_cast<double>(ledger.scattered_away) * report.unit;
    colour.given_up += static_cast<double>(ledger.given_up) * report.unit;
    colour.clipped += static_cast<double>(ledger.clipped) * report.unit;
  }
  report.emitted += static_cast<double>(ledger.emitted) * report.unit;
  report.deposited += static_cast<double>(ledger.deposited) * report.unit;
  report.escaped += static_cast<double>(ledger.escaped) * report.unit;
  for (std::size_t face = 0; face < wire::kFaces; ++face) {
    report.escaped_by_face[face] += static_cast<double>(ledger.escaped_by_face[face]) * report.unit;
  }
  report.scattered_away += static_cast<double>(ledger.scattered_away) * report.unit;
  report.given_up += static_cast<double>(ledger.given_up) * report.unit;
  report.clipped += static_cast<double>(ledger.clipped) * report.unit;
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

  // For rays that passed their checks. Throws WouldBlock.
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
  // All of it but the device, the limits, and who waits for descriptors. Throws CheckpointFault.
  void state(Archive& archive);
  // The link goes to a new board: everything that has not come back is sent again, in its order.
  // `set_sampling(view, towards_eye)` is called before each, with what it was submitted with.
  void send_again(const std::function<void(const View&, Vec3)>& set_sampling);

 private:
  struct Batch;
  void state(Archive& archive, Batch& batch) const;

  struct Part {
    std::uint32_t command = 0;
    std::size_t rays = 0;
    wire::Payload encoded;      // until the result has come
    std::vector<double> units;  // kIntegral: of each ray's sum
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
    std::vector<Part> parts;
    std::shared_ptr<Event> worked_out;  // once somebody has asked for its descriptor

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
  // Forgets a batch of which only a part was sent: results that still come are ignored.
  void drop(std::uint32_t ticket);
  void collect(Batch& batch);
  void complete(Batch& batch, Picoseconds deadline);
  // Takes a complete batch out of the list and decodes its rays, into as much room as it has rays.
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
