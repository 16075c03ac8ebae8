// What a board tells of its inside while it works; observe/ makes files of it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/pixel_life.h"
#include "gicube/v1/board_config.pb.h"
#include "gicube/wire/counter_list.h"
#include "words/clock.h"

namespace gicube::emu {

class Observer;
struct BusDelivery;
struct BusTransaction;

class BoardObserver {
 public:
  virtual ~BoardObserver() = default;

  // A board of this configuration begins anew, at time 0.
  virtual void power_up(const v1::BoardConfig& /*config*/) {}

  // For the machine of a level that has cycles; null if nobody looks at them.
  virtual Observer* observer() { return nullptr; }
  // Whether begin_command() needs to know the time.
  virtual bool places_cycles() const { return false; }
  // The machine's next cycles belong to a command whose turn at the DSP begins at `begin`, until end_command().
  virtual void begin_command(Picoseconds /*begin*/, std::uint32_t /*ticket*/) {}
  virtual void end_command() {}
  // Whether counted() is to be called at a command's end.
  virtual bool wants_counters() const { return false; }
  virtual void counted(const std::vector<wire::Counter>& /*counters*/) {}

  // The pixel whose rays it is to be told with each picture, if any.
  virtual std::optional<ExplainedPixel> explained_pixel() { return std::nullopt; }

  // The host waited for the board: "read register", "wait".
  virtual void host_waited(const char* /*what*/, Picoseconds /*begin*/, Picoseconds /*end*/) {}

  // What can no longer change. A transfer; in the order of their ends.
  virtual void transferred(const BusDelivery& delivery) = 0;
  // A turn at the DSP; in the order of their begins.
  virtual void served(const BusTransaction& transaction, Picoseconds begin, Picoseconds end) = 0;
};

}  // namespace gicube::emu
