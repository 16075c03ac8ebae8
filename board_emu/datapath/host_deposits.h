// Deposits of one command for blocks whose irradiance is on the host. They stay in the DSP's memory until the next
// command.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "datapath/scattering.h"
#include "gicube/archive.h"
#include "gicube/wire/command.h"
#include "gicube/wire/memory_map.h"
#include "words/record_list.h"

namespace gicube::emu {

class HostDeposits {
 public:
  static constexpr std::size_t kMax = wire::kHostDeposits.bytes / wire::kHostDepositBytes;

  void begin() {
    sums_.clear();
    list_.clear();
  }
  // `word`: block * n^3 + voxel of the block. Thread-safe. Throws RoutineFault if there are too many.
  void add(std::uint64_t word, std::uint32_t units) {
    const std::lock_guard lock(mutex_);
    sums_[word] += units;
    if (sums_.size() > kMax)
      throw RoutineFault("more than 2^26 voxels of blocks at the host received energy in one command");
  }
  // Only add() and state() may be called during a command. settle() lists the added deposits in an order that does not
  // depend on threads.
  void settle() {
    for (const auto& [word, units] : sums_) list_.push_back({word, units});
    sums_.clear();
    std::ranges::sort(list_, {}, &wire::HostDeposit::word);
  }
  std::size_t count() const { return list_.size(); }
  std::uint64_t memory_bytes() const { return list_.capacity() * sizeof(wire::HostDeposit); }
  // Offset and length must be multiples of a record.
  std::optional<std::vector<std::uint8_t>> read(std::uint64_t offset, std::uint64_t length) const {
    return read_records(list_, offset, length);
  }
  // Also valid during a command.
  void state(Archive& archive) {
    std::vector<wire::HostDeposit> sums;
    for (const auto& [word, units] : sums_) sums.push_back({word, units});
    std::ranges::sort(sums, {}, &wire::HostDeposit::word);
    records_state(archive, "sums", sums, wire::kHostDeposits.bytes);
    records_state(archive, "list", list_, wire::kHostDeposits.bytes);
    if (!archive.loads()) return;
    for (const wire::HostDeposit& each : sums) sums_[each.word] += each.units;
  }

 private:
  std::mutex mutex_;  // for sums_
  std::unordered_map<std::uint64_t, std::uint64_t> sums_;
  std::vector<wire::HostDeposit> list_;
};

}  // namespace gicube::emu
