// A memory channel of the pass machine and the processors that it serves. One that is alone sends its requests itself, as it makes
// them; two take turns, a request a cycle, as at cycle/memory_port.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "asic/memory_standards.h"
#include "gicube/v1/board_config.pb.h"
#include "words/clock.h"

namespace gicube::emu {

class PassProcessor;

struct PassMemory {
  PassMemory(const v1::BoardConfig& config, std::size_t blocks)
      : channel(make_memory(config, static_cast<std::uint32_t>(blocks))) {}

  bool shared() const { return clients.size() > 1; }
  // When the next request is sent; kNoCycle if none waits.
  Cycle next() const;
  void send();

  std::unique_ptr<dram::Memory> channel;
  std::vector<PassProcessor*> clients;
  std::size_t turn = 0;  // of them
  Cycle asked = 0;       // in which it took the last packet on
};

}  // namespace gicube::emu
