// What a board tells of its inside while it works; observe/ makes files of it.
#pragma once

#include "board/timeline.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

class Observer;

class BoardObserver : public TimelineWatcher {
 public:
  // A board of this configuration begins anew, at time 0.
  virtual void power_up(const v1::BoardConfig& config) = 0;

  // For the machine of a level that has cycles; null if nobody looks at them.
  virtual Observer* observer() = 0;
  // Whether begin_command() needs to know the time.
  virtual bool places_cycles() const = 0;
  // The machine's next cycles belong to a command whose turn at the DSP begins at `begin`, until end_command().
  virtual void begin_command(Picoseconds begin) = 0;
  virtual void end_command() = 0;

  // The host waited for the board: "read register", "wait".
  virtual void host_waited(const char* what, Picoseconds begin, Picoseconds end) = 0;
};

}  // namespace gicube::emu
