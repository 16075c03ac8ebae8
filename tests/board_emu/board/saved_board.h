// Boards that are saved into bytes, also in the middle of a command, and made of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "board/board.h"
#include "board/board_observer.h"
#include "board/checkpoint.h"
#include "config/config.h"
#include "cycle/observer.h"
#include "gicube/wire/bytes.h"
#include "gicube/wire/checksum.h"
#include "server/faults/fault_point.h"

namespace gicube::emu {

inline std::string saved(Board& board) {
  std::string bytes;
  save_checkpoint(board, [&bytes](std::string_view more) { bytes += more; });
  return bytes;
}

// With the fault plan of the link to it.
inline std::string saved(Board& board, const FaultPoint& link) {
  std::string bytes;
  SavedFaults faults = link.saved();
  save_checkpoint(
      board, [&bytes](std::string_view more) { bytes += more; },
      [&faults](Archive& archive) { archive("host.faults", faults); });
  return bytes;
}

inline std::unique_ptr<Board> board_of(const v1::BoardConfig& config, BoardObserver* observer = nullptr) {
  return std::make_unique<Board>(config, config_hash(config), observer);
}

inline std::unique_ptr<Board> restored(const std::string& bytes, BoardObserver* observer = nullptr) {
  const Checkpoint checkpoint(bytes);
  auto board = board_of(checkpoint.header().config(), observer);
  checkpoint.restore(*board);
  return board;
}

// With the checksum of what it now is.
inline std::string changed(const std::string& bytes, const std::function<void(v1::Checkpoint&)>& change) {
  v1::Checkpoint message;
  if (!message.ParseFromString(bytes)) throw std::runtime_error("no checkpoint");
  change(message);
  message.clear_crc32c();
  std::string out = message.SerializeAsString();
  std::vector<std::uint8_t> end(5);
  end[0] = 3 << 3 | 5;
  wire::store(std::span(end), 1,
              wire::crc32c(std::span(reinterpret_cast<const std::uint8_t*>(out.data()), out.size())));
  return out.append(end.begin(), end.end());
}

inline v1::StateField& field(v1::Checkpoint& message, std::string_view name) {
  for (v1::StateField& each : *message.mutable_fields()) {
    if (each.name() == name) return each;
  }
  throw std::runtime_error("no field " + std::string(name));
}

// Saves a board in the middle of a command.
class Saver : public BoardObserver, public Observer {
 public:
  Observer* observer() override { return this; }
  void transferred(const BusDelivery&) override {}
  void served(const BusTransaction&, Picoseconds, Picoseconds) override {}

  // So many cycles after the next run of the machine begins or goes on, if it is not over by then.
  void save_in(Cycle cycles, Board& board) {
    cycles_ = cycles;
    board_ = &board;
    at_ = kNoCycle;
    bytes_.clear();
  }
  const std::string& bytes() const { return bytes_; }

  void begins(Cycle now, Machine&) override {
    at_ = board_ != nullptr && at_ == kNoCycle ? now + cycles_ : kNoCycle;
    if (at_ == kNoCycle) board_ = nullptr;
  }
  Cycle next(Cycle from) override { return board_ == nullptr ? kNoCycle : std::max(from, at_); }
  void see(Cycle now, const Machine&) override {
    if (board_ == nullptr || now < at_) return;
    bytes_ = saved(*board_);
    board_ = nullptr;
  }

 private:
  Board* board_ = nullptr;
  Cycle cycles_ = 0;
  Cycle at_ = kNoCycle;
  std::string bytes_;
};

}  // namespace gicube::emu
