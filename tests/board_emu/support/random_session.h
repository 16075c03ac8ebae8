// A host that does anything with a board, at random: what it sends depends on its seed and on what came back.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "board/board.h"
#include "random_machine.h"

namespace gicube::emu {

// Copied, it goes on from where it is, with another board.
class RandomHost {
 public:
  explicit RandomHost(unsigned seed, int block_voxels) : seed_(seed), n_(block_voxels) {}

  // Called before each transaction that is sent, with its bytes as a frame: for what happens on the way.
  void on_send(std::function<void(Board& board, std::size_t bytes)> called) { on_send_ = std::move(called); }

  // Sets a small volume and its tables.
  void begin(Board& board);
  // One thing that a host does: some transactions.
  void step(Board& board);
  // Waits for all that is under way.
  void end(Board& board);
  // Reads all that the volume's memories hold, and the picture's first pixels.
  void read_memories(Board& board);

  // All that has come back so far, with its times: a line each. It begins with what it is: completion, counters, or
  // another reply.
  const std::vector<std::string>& heard() const { return heard_; }

 private:
  TransactionResult send(Board& board, wire::FrameType type, std::vector<std::uint8_t> payload);
  void write_register(Board& board, std::uint32_t offset, std::uint32_t value);
  void write_memory(Board& board, std::uint64_t address, const std::vector<std::uint8_t>& bytes);
  void read_memory(Board& board, std::uint64_t address, std::uint64_t length);
  void command(Board& board, const std::vector<std::uint8_t>& payload);
  void wait_for_one(Board& board, Dice& dice);
  std::vector<std::uint8_t> render(Dice& dice);
  std::vector<std::uint8_t> illuminate(Dice& dice);
  std::vector<std::uint8_t> trace(Dice& dice);
  std::vector<std::uint8_t> pairs(Dice& dice) const;
  std::vector<std::uint8_t> resume(Dice& dice);
  std::vector<std::uint8_t> block(Dice& dice) const;
  void change_memory(Board& board, Dice& dice);
  void take_trapped(const std::vector<std::uint8_t>& payload, bool light);

  unsigned seed_;
  int n_;
  unsigned steps_ = 0;
  std::uint32_t next_id_ = 1;
  std::uint64_t now_ps_ = 0;
  std::vector<std::uint32_t> under_way_;  // tickets
  std::vector<std::uint32_t> lights_;     // tickets of commands whose completions begin with a ledger
  std::vector<wire::TrappedRay> trapped_;
  bool last_was_light_ = false;
  std::vector<std::string> heard_;
  std::function<void(Board&, std::size_t)> on_send_;
};

}  // namespace gicube::emu
