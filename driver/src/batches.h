// The ray batches that are under way: what was submitted and not received yet.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "device.h"
#include "gicube/ray.h"

namespace gicube {

class Batches {
 public:
  explicit Batches(Device& device) : device_(device) {}

  // For rays that passed their checks.
  Ticket submit(std::span<const HostRay> rays);
  // Throws BadArgument for an unknown ticket; Rejected or Unsupported if the board refused the batch, which is gone then.
  RayBatch receive(Ticket ticket);
  // Throws Rejected or Unsupported for one batch that the board refused, which is gone then; the others stay.
  std::vector<RayBatch> poll();

 private:
  // As many rays as one command holds.
  struct Part {
    std::uint32_t command = 0;
    std::size_t rays = 0;
    std::optional<CommandResult> result;
  };
  struct Batch {
    Picoseconds completed = 0;
    std::vector<Part> parts;

    bool complete() const;
  };
  using Entry = std::map<std::uint32_t, Batch>::iterator;

  void collect(Batch& batch);
  RayBatch release(Entry entry);

  Device& device_;
  std::uint32_t last_ticket_ = 0;
  std::map<std::uint32_t, Batch> batches_;
};

}  // namespace gicube
