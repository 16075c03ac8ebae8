// Changed checkpoints: a damaged one is refused; one that was made up is refused in words, or makes a board that works.
#include "board/checkpoint.h"

#include <algorithm>
#include <array>
#include <memory>

#include "board/board_observer.h"
#include "board_moves.h"
#include "config/config.h"
#include "cycle/observer.h"
#include "firmware/routines/routine_table.h"
#include "gicube/wire/checksum.h"
#include "impatience.h"
#include "input.h"

namespace gicube::fuzz {
namespace {

constexpr std::uint64_t kMaxMemory = std::uint64_t{64} << 20;

// Saves a board in its last command.
class Saver : public emu::BoardObserver, public emu::Observer {
 public:
  emu::Observer* observer() override { return this; }
  void transferred(const emu::BusDelivery&) override {}
  void served(const emu::BusTransaction&, emu::Picoseconds, emu::Picoseconds) override {}
  void begins(emu::Cycle now, emu::Machine&) override { at_ = now + kCycles; }
  emu::Cycle next(emu::Cycle from) override { return std::max(from, at_); }
  void see(emu::Cycle, const emu::Machine&) override {
    at_ = emu::kNoCycle;
    bytes.clear();
    emu::save_checkpoint(*board, [this](std::string_view more) { bytes += more; });
  }

  emu::Board* board = nullptr;
  std::string bytes;

 private:
  static constexpr emu::Cycle kCycles = 700;  // chosen: rays are everywhere by then
  emu::Cycle at_ = emu::kNoCycle;
};

// A board that has done the known moves, and has a picture under way; or `in_command`.
std::string saved_board(const char* fidelity, bool in_command = false) {
  const std::string text = std::string("threads: 1 fidelity: ") + fidelity +
                           " asic { max_volume_voxels: 32 block_voxels: 8 processors: 2 queue_rays: 16 } "
                           "dsp { framebuffer_mb: 1 run_rays: 4 }";
  const v1::BoardConfig config = emu::resolve(emu::parse_config(text).config);
  Saver saver;
  emu::Board board(config, emu::config_hash(config), in_command ? &saver : nullptr, &emu::built_in_routines(),
                   kMaxMemory);
  saver.board = &board;
  emu::Progress work;
  for (int round = 0; round < 2; ++round) {
    for (Move move : known_moves()) {
      move.header.id += static_cast<std::uint32_t>(round) * 100;
      const bool waits = move.header.type == wire::FrameType::kWait;
      if (!waits || round == 0) board.transact(move.header, move.payload, work);
    }
  }
  if (in_command) return saver.bytes;
  std::string bytes;
  emu::save_checkpoint(board, [&bytes](std::string_view more) { bytes += more; });
  return bytes;
}

// Another number, or one less, in some fields.
std::string with_other_numbers(const std::string& saved, Input& input) {
  static constexpr std::array kTelling{std::uint64_t{0},       std::uint64_t{1},           std::uint64_t{7},
                                       std::uint64_t{255},     std::uint64_t{0x7FFF'FFFF}, std::uint64_t{0xFFFF'FFFF},
                                       std::uint64_t{1} << 40, ~std::uint64_t{0}};
  v1::Checkpoint message;
  expect(message.ParseFromString(saved), "a checkpoint is a message");
  for (int edits = 0; !input.empty() && edits < 8; ++edits) {
    v1::StateField& field = *message.mutable_fields(static_cast<int>(input.u16() % message.fields_size()));
    const std::uint32_t where = input.u32();
    const std::uint8_t what = input.u8();
    if (field.numbers().empty()) continue;
    if (what == 255) {
      field.mutable_numbers()->RemoveLast();
    } else {
      field.set_numbers(static_cast<int>(where % static_cast<std::uint32_t>(field.numbers_size())),
                        what < 128 ? std::uint64_t{what} : kTelling[what % kTelling.size()]);
    }
  }
  return message.SerializeAsString();
}

}  // namespace

void checkpoint(Bytes input_bytes) {
  static const std::array kSaved{saved_board("functional"), saved_board("cycle"), saved_board("cycle", true)};
  Input input(input_bytes);
  const std::string& saved = kSaved[input.below(kSaved.size())];
  std::string bytes = saved;
  const std::uint8_t kind = input.u8();
  const bool sealed = (kind & 1) != 0;
  if ((kind & 4) != 0) bytes = with_other_numbers(saved, input);
  if ((kind & 2) != 0) bytes.resize(input.u32() % bytes.size());
  for (int edits = 0; !input.empty() && !bytes.empty() && edits < 32; ++edits) {
    const std::size_t at = input.u32() % bytes.size();
    bytes[at] = static_cast<char>(input.u8());
  }
  const bool changed = bytes != saved;
  if (sealed && bytes.size() > 5) {
    const std::size_t end = bytes.size() - 5;
    bytes[end] = 3 << 3 | 5;  // the checksum's tag
    wire::store(std::span(reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()), end + 1,
                wire::crc32c(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), end)));
  }
  std::unique_ptr<emu::Board> board;
  try {
    const emu::Checkpoint checkpoint(std::move(bytes));
    const v1::BoardConfig& config = checkpoint.header().config();
    if (config.threads() > 4 || config.asic().processors() > 16 || config.asic().max_volume_voxels() > 64) return;
    board =
        std::make_unique<emu::Board>(config, emu::config_hash(config), nullptr, &emu::built_in_routines(), kMaxMemory);
    checkpoint.restore(*board);
  } catch (const CheckpointFault&) {
    expect(changed, "what was not changed is taken");
    return;
  }
  expect(!changed || sealed, "what was changed is refused");
  emu::Progress work;
  Impatience::instance().begin(work);
  for (Move move : known_moves()) {
    move.header.id += 1000;
    if (move.header.type == wire::FrameType::kWait) continue;
    board->transact(move.header, move.payload, work);
  }
  Impatience::instance().end();
}

}  // namespace gicube::fuzz
