// Transactions into a board without sockets: nothing that a host sends may throw, the board's clock never runs
// backwards, every command is answered once, and after a reset the board works as on its first day.
#include "board/board.h"

#include <map>
#include <memory>

#include "board_moves.h"
#include "config/config.h"
#include "firmware/routines/routine_table.h"
#include "impatience.h"

namespace gicube::fuzz {
namespace {

using wire::FrameType;

struct Machine {
  explicit Machine(const char* text) : config(resolved(text)) { first_day = known_scene(); }

  void renew() {
    board.reset();
    board = std::make_unique<emu::Board>(config, 1, nullptr, &emu::built_in_routines());
  }

  static v1::BoardConfig resolved(const char* text) { return emu::resolve(emu::parse_config(text).config); }

  emu::TransactionResult send(const Move& move, emu::Progress& work) {
    return board->transact(move.header, move.payload, work);
  }

  // Everything that a small scene brings back, with its times.
  std::vector<std::uint8_t> known_scene() {
    renew();
    emu::Progress work;
    std::vector<std::uint8_t> all;
    std::uint64_t now = 0;
    for (Move move : known_moves()) {
      move.header.time_ps = now;
      const emu::TransactionResult outcome = send(move, work);
      for (const emu::Completion& completion : outcome.completions) {
        all.insert(all.end(), completion.payload.begin(), completion.payload.end());
        append(all, completion.time_ps);
      }
      if (!outcome.reply) continue;
      all.insert(all.end(), outcome.reply->payload.begin(), outcome.reply->payload.end());
      append(all, now = outcome.reply->time_ps);
    }
    return all;
  }

  static void append(std::vector<std::uint8_t>& bytes, std::uint64_t number) {
    for (int shift = 0; shift < 64; shift += 8) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  }

  v1::BoardConfig config;
  std::unique_ptr<emu::Board> board;
  std::vector<std::uint8_t> first_day;
};

bool is_posted(FrameType type) {
  return type == FrameType::kRegisterWrite || type == FrameType::kMemoryWrite || type == FrameType::kCommand;
}

void play(Machine& machine, Input& input, emu::Progress& work) {
  std::uint64_t now = 0;
  std::map<std::uint32_t, int> issued;  // and not answered yet, by ticket
  for (std::uint32_t id = 1; !input.empty() && id < 200; ++id) {
    Move move = next_move(input, id);
    const bool warps = move.header.time_ps != 0;
    if (!warps) move.header.time_ps = now;
    const emu::TransactionResult outcome = machine.send(move, work);
    if (move.header.type == FrameType::kCommand && !outcome.ticket_in_use) {
      expect(++issued[move.header.id] == 1, "a ticket names one command at a time");
    }
    expect(outcome.reply.has_value() != is_posted(move.header.type), "what is posted has no reply, all else has one");
    std::uint64_t last = 0;
    for (const emu::Completion& completion : outcome.completions) {
      expect(issued[completion.ticket]-- > 0, "a completion answers a command, and each but once");
      expect(completion.time_ps >= last, "completions come in the order of their times");
      last = completion.time_ps;
    }
    if (!outcome.reply || outcome.reply->error != wire::ErrorCode::kNone) continue;
    expect(outcome.reply->time_ps >= move.header.time_ps, "a reply is not earlier than its request");
    if (!warps) now = outcome.reply->time_ps;
  }
}

}  // namespace

void board(Bytes bytes) {
  static const char* const kBoards[] = {
      "threads: 1 asic { max_volume_voxels: 32 block_voxels: 8 } dsp { framebuffer_mb: 1 } bus { model: agp2x }",
      "threads: 1 fidelity: cycle asic { max_volume_voxels: 32 block_voxels: 8 processors: 2 queue_rays: 16 datapath: "
      "wide } "
      "dsp { framebuffer_mb: 1 run_rays: 4 }"};
  static std::map<std::size_t, std::unique_ptr<Machine>> machines;
  Input input(bytes);
  const std::size_t which = input.u8() % 2;
  std::unique_ptr<Machine>& machine = machines[which];
  if (!machine) machine = std::make_unique<Machine>(kBoards[which]);
  machine->renew();
  emu::Progress work;
  Impatience::instance().begin(work);
  try {
    play(*machine, input, work);
  } catch (...) {
    Impatience::instance().end();
    throw;
  }
  Impatience::instance().end();
  if (bytes.size() % 4 == 0) expect(machine->known_scene() == machine->first_day, "a new board is as on its first day");
}

}  // namespace gicube::fuzz
