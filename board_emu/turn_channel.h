// One RDRAM channel as the approximate level knows it: the bounds that rdram/channel.h keeps between activations, precharges
// and reads, but no wires on which commands find gaps, and nothing but reads.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rdram/channel.h"
#include "rdram/device.h"
#include "rdram/location.h"
#include "rdram/timing.h"

namespace gicube::emu {

class TurnChannel {
 public:
  TurnChannel(const v1::RdramConfig& config, std::uint32_t devices);

  // When the data are there of the packet at `at`, asked for at `arrival`, which never decreases from call to call.
  rdram::Tcycle read(const rdram::Location& at, rdram::Tcycle arrival) {
    if (arrival >= refresh_due_) [[unlikely]]
      refresh(arrival);
    Bank& bank = banks_[std::size_t{at.device} * rdram::kBanks + at.bank];
    if (bank.row != at.row) open(at, bank, arrival);
    const rdram::Tcycle begin = std::max({arrival, bank.reads, reads_});
    reads_ = begin + read_gap_;
    bank.closes = std::max(bank.closes, begin + read_to_close_);
    ++packets_;
    return begin + data_end_;
  }

  rdram::ChannelCounters counters() const;

 private:
  struct Bank {
    std::int32_t row = rdram::kClosed;
    rdram::Tcycle opens = 0, reads = 0, closes = 0;  // from when on it can
  };
  struct Device {
    std::uint32_t open = 0;               // banks, as a mask
    rdram::Tcycle opens = 0, closes = 0;  // from when on one of its banks can
  };

  void open(const rdram::Location& at, Bank& bank, rdram::Tcycle arrival);
  void close_around(std::uint16_t device, int bank, rdram::Tcycle asked);
  void refresh(rdram::Tcycle now);

  std::vector<Device> devices_;
  std::vector<Bank> banks_;  // of all devices
  rdram::Tcycle reads_ = 0;  // from when on the channel can
  std::uint32_t read_gap_, data_end_;
  std::uint32_t open_to_open_, open_to_read_, open_to_close_, read_to_close_, close_to_open_, close_to_close_;
  std::uint32_t again_;  // from opening a bank to opening it again
  std::uint32_t refresh_to_open_, refreshed_again_;
  std::uint64_t refresh_interval_, refreshes_ = 0;
  rdram::Tcycle refresh_due_ = rdram::kNever;
  std::uint64_t packets_ = 0, misses_ = 0, conflicts_ = 0, closed_ = 0;
};

}  // namespace gicube::emu
