#include "memory_port.h"

#include <algorithm>
#include <utility>

namespace gicube::emu {

MemoryPort::MemoryPort(const v1::BoardConfig& config, std::vector<MemoryClient> clients, std::size_t blocks)
    : clients_(std::move(clients)),
      channel_(make_memory(config, static_cast<std::uint32_t>(blocks * clients_.size()))),
      to_memory_(config.asic().core_khz(), memory_standard(config).clock_khz),
      to_core_(memory_standard(config).clock_khz, config.asic().core_khz()),
      latency_(memory_standard(config).latency) {}

inline void MemoryPort::send(std::size_t which, Cycle now) {
  const MemoryClient& client = clients_[which];
  latest_ = now;
  if (client.next_is_write()) {
    const TileWrite write = client.writes->next();
    const std::uint32_t block = block_in_memory(write.block, which);
    if (write.fetch) {
      channel_->read(block, write.tile, to_memory_.from(now));
    } else {
      channel_->write(block, write.tile, to_memory_.from(now));
    }
    client.writes->send(now);
    return;
  }
  MissQueue& queue = *client.misses;
  const Answer answer = read(block_in_memory(queue.next().block, which), queue.next().tile, now);
  queue.send(now, answer.arrival, answer.delay);
}

// Serves the processor whose turn it is, or the next one with a request.
bool MemoryPort::serve(Cycle now) {
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    const std::size_t which = turn_ + i < clients_.size() ? turn_ + i : turn_ + i - clients_.size();
    if (!clients_[which].can_send(now)) continue;
    send(which, now);
    turn_ = which + 1 < clients_.size() ? which + 1 : 0;
    return true;
  }
  return false;
}

bool MemoryPort::serve_ahead() {
  const MemoryClient& client = clients_.front();
  while (!client.all_sent()) send(0, std::max(client.next_asked(), latest_) + 1);
  return true;
}

}  // namespace gicube::emu
