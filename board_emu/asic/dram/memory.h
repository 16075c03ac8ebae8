// The interface of one channel's memory: tiles of blocks, whatever the standard and its layout.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <utility>
#include <vector>

#include "asic/dram/constraint.h"
#include "asic/sim/causes.h"
#include "gicube/archive.h"

namespace gicube::emu::dram {

using emu::Delay;

// The address of a packet in a channel's memory.
struct Location {
  std::uint16_t device = 0;
  std::uint16_t row = 0;
  std::uint8_t bank = 0;
  std::uint16_t column = 0;  // packet within the row

  friend constexpr bool operator==(const Location&, const Location&) = default;
};

struct Access {
  Tcycle data_begin = 0;  // on the data wires at the controller
  Tcycle data_end = 0;    // the clock after the last one with data
  Delay cause = Delay::kTransfer;
};

struct IssuedCommand {
  Command command;
  bool tight;  // the model claims that it was not possible one clock earlier
  std::uint16_t device;
  std::uint16_t row;  // kActivate only
  std::uint8_t bank;
  std::uint16_t column;  // kRead and kWrite only
  Tcycle begin;
  Tcycle asked;  // arrival of the packet that it serves, or the time at which the refresh was due
};

struct ChannelCounters {
  std::uint64_t packets_read = 0;
  std::uint64_t packets_written = 0;
  std::uint64_t row_hits = 0;    // packets whose row was open
  std::uint64_t row_misses = 0;  // other packets; one activation each
  std::uint64_t conflicts = 0;   // row misses that had to precharge first
  std::uint64_t activates = 0;   // refreshes not counted
  std::uint64_t precharges = 0;  // including those for refreshes
  std::uint64_t refreshes = 0;
  std::uint64_t dq_busy = 0;     // clocks
  std::uint64_t turnaround = 0;  // clocks in which the data wires were idle because the direction changed

  friend bool operator==(const ChannelCounters&, const ChannelCounters&) = default;
};

class Memory {
 public:
  virtual ~Memory() = default;

  // Tile `tile` of the channel's block `block`, requested at clock `arrival`, which never decreases from call to call
  // (reads and writes together). Its packets are adjacent in one row. The first has the 36-bit words of the four
  // voxels; the others have green and blue irradiance, if there are three words of it, and then colours. Only packets
  // with irradiance are written.
  virtual Access read(std::uint32_t block, std::uint32_t tile, Tcycle arrival) = 0;
  virtual Access write(std::uint32_t block, std::uint32_t tile, Tcycle arrival) = 0;

  virtual std::uint32_t devices() const = 0;
  virtual ChannelCounters counters() const = 0;
  // Packets read and written by each bank, device by device.
  virtual std::vector<std::uint64_t> bank_packets() const = 0;
  virtual void dump(std::ostream& out) const = 0;  // for a stall report
  // Appends every further command, in the order of scheduling; null stops the trace.
  virtual void set_trace(std::vector<IssuedCommand>* sink) = 0;
  virtual void state(Archive& archive) = 0;
};

// A standard's channel, addressed through its layout.
template <typename Layout, typename Channel>
class LaidOut final : public Memory {
 public:
  // `config`: the standard's own message. `written`: packets per write of a tile.
  template <typename Config>
  LaidOut(Layout layout, const Config& config, std::uint32_t written)
      : layout_(std::move(layout)), channel_(config, layout_.devices()), written_(written) {}

  Access read(std::uint32_t block, std::uint32_t tile, Tcycle arrival) override {
    const Location at = layout_.locate(block, tile);
    Access access = channel_.read(at, arrival);
    if (layout_.packets_of_tile() > 1) [[unlikely]]
      access.data_end = read_others(at, arrival);
    return access;
  }
  Access write(std::uint32_t block, std::uint32_t tile, Tcycle arrival) override {
    Location at = layout_.locate(block, tile);
    Access access = channel_.write(at, arrival);
    for (std::uint32_t more = written_ - 1; more > 0; --more) {
      ++at.column;
      access.data_end = channel_.write(at, arrival).data_end;
    }
    return access;
  }
  std::uint32_t devices() const override { return layout_.devices(); }
  ChannelCounters counters() const override { return channel_.counters(); }
  std::vector<std::uint64_t> bank_packets() const override { return channel_.bank_packets(); }
  void dump(std::ostream& out) const override { channel_.dump(out); }
  void set_trace(std::vector<IssuedCommand>* sink) override { channel_.set_trace(sink); }
  void state(Archive& archive) override { channel_.state(archive); }

 private:
  // Reads the tile's packets after the first. Returns the end of their data.
  [[gnu::noinline]] Tcycle read_others(Location at, Tcycle arrival) {
    Tcycle end = 0;
    for (std::uint32_t more = layout_.packets_of_tile() - 1; more > 0; --more) {
      ++at.column;
      end = channel_.read(at, arrival).data_end;
    }
    return end;
  }

  Layout layout_;
  Channel channel_;
  std::uint32_t written_;
};

// Properties of a standard that the rest of the board uses.
struct Standard {
  const char* name = "";     // name of its message in the configuration and of its counters
  const char* label = "";    // name in texts for people
  const char* clock = "";    // the unit of its times
  const char* signals = "";  // signals of a channel, by kind
  std::uint32_t signal_count = 0;
  std::uint32_t sharing = 1;  // processors on a channel
  std::uint32_t clock_khz = 1;
  std::uint32_t latency = 0;      // clocks from the last data to the fill queue
  std::uint32_t tile_clocks = 1;  // clocks of a tile's packets on the data wires
  std::uint32_t max_devices = 1;  // the most devices of a channel
};

}  // namespace gicube::emu::dram
