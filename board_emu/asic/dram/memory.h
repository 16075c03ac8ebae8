// The memory of one channel as its users see it: tiles of blocks, whatever the standard and the places in it.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <utility>
#include <vector>

#include "asic/dram/access.h"

namespace gicube::emu::dram {

class Memory {
 public:
  virtual ~Memory() = default;

  // The packet of tile `tile` of the channel's block `block`, asked for at clock `arrival`, which never decreases from
  // call to call (reads and writes together).
  virtual Access read(std::uint32_t block, std::uint32_t tile, Tcycle arrival) = 0;
  virtual Access write(std::uint32_t block, std::uint32_t tile, Tcycle arrival) = 0;

  virtual std::uint32_t devices() const = 0;
  virtual ChannelCounters counters() const = 0;
  virtual void describe(std::ostream& out) const = 0;  // for a stall report
  // Every command from now on is appended, in the order of placing; null stops it.
  virtual void set_trace(std::vector<IssuedCommand>* sink) = 0;
};

// A standard's layout before its channel.
template <typename Layout, typename Channel>
class LaidOut final : public Memory {
 public:
  // `config`: the standard's own message.
  template <typename Config>
  LaidOut(Layout layout, const Config& config) : layout_(std::move(layout)), channel_(config, layout_.devices()) {}

  Access read(std::uint32_t block, std::uint32_t tile, Tcycle arrival) override {
    return channel_.read(layout_.locate(block, tile), arrival);
  }
  Access write(std::uint32_t block, std::uint32_t tile, Tcycle arrival) override {
    return channel_.write(layout_.locate(block, tile), arrival);
  }
  std::uint32_t devices() const override { return layout_.devices(); }
  ChannelCounters counters() const override { return channel_.counters(); }
  void describe(std::ostream& out) const override { channel_.describe(out); }
  void set_trace(std::vector<IssuedCommand>* sink) override { channel_.set_trace(sink); }

 private:
  Layout layout_;
  Channel channel_;
};

// What the rest of the board has to know of a standard.
struct Standard {
  const char* name = "";     // of its message in the configuration, and of its counters
  const char* label = "";    // for people
  const char* clock = "";    // the unit of its times
  const char* signals = "";  // of a channel, by kind
  std::uint32_t signal_count = 0;
  std::uint32_t sharing = 1;                // processors on a channel
  std::uint32_t clocks_per_core_cycle = 1;  // of its clock
  std::uint32_t latency = 0;                // clocks from the last data to the fill queue
  std::uint32_t packet_clocks = 1;          // of a packet on the data wires
  std::uint32_t max_devices = 1;            // of a channel
};

}  // namespace gicube::emu::dram
