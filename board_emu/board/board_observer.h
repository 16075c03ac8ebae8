// Interface for observing a board. observe/ writes files from it.
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

  // A board of this configuration starts at time 0.
  virtual void power_up(const v1::BoardConfig& /*config*/) {}

  // Observer of the machine, for levels with cycles; may be null.
  virtual Observer* observer() { return nullptr; }
  // Whether begin_command() needs the time.
  virtual bool places_cycles() const { return false; }
  // The following cycles of the machine belong to a command whose turn at the DSP begins at `begin`, until
  // end_command().
  virtual void begin_command(Picoseconds /*begin*/, std::uint32_t /*ticket*/) {}
  virtual void end_command() {}
  // Whether counted() is called at the end of each command.
  virtual bool wants_counters() const { return false; }
  virtual void counted(const std::vector<wire::Counter>& /*counters*/) {}

  // The pixel whose rays are reported for each image, if any.
  virtual std::optional<ExplainedPixel> explained_pixel() { return std::nullopt; }

  // The host waited for the board; `what` is for example "read register" or "wait".
  virtual void host_waited(const char* /*what*/, Picoseconds /*begin*/, Picoseconds /*end*/) {}

  // The following calls report final times. Transfers are reported in the order of their ends.
  virtual void transferred(const BusDelivery& delivery) = 0;
  // A turn at the DSP. Turns are reported in the order of their begins.
  virtual void served(const BusTransaction& transaction, Picoseconds begin, Picoseconds end) = 0;
};

}  // namespace gicube::emu
