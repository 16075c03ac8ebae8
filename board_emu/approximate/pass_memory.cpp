#include "pass_memory.h"

#include <algorithm>
#include <utility>

#include "pass_processor.h"

namespace gicube::emu {

Cycle PassMemory::next() const {
  Cycle first = kNoCycle;
  for (const PassProcessor* client : clients) first = std::min(first, client->next_request());
  return first == kNoCycle ? first : std::max(first, asked) + 1;
}

void PassMemory::send() {
  asked = next();
  while (clients[turn]->next_request() >= asked) turn = (turn + 1) % clients.size();
  clients[std::exchange(turn, (turn + 1) % clients.size())]->send_request(asked);
}

}  // namespace gicube::emu
