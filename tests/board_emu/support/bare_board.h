// A board without a driver: tests speak to it in transactions, and read its answers.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "board/board.h"
#include "gicube/wire/command.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"
#include "gicube/wire/voxel.h"

namespace gicube::emu {

// What a test wants to stand in the volume at voxel (x, y, z).
using VoxelField = std::function<wire::Voxel(int x, int y, int z)>;

class BareBoard {
 public:
  // `observer` and `routines` may be null.
  explicit BareBoard(const v1::BoardConfig& config = {}, BoardObserver* observer = nullptr,
                     const Routines* routines = nullptr, std::uint64_t max_memory_bytes = kUnlimitedMemory)
      : board_(config, 0x1234, observer, routines, max_memory_bytes),
        n_(static_cast<int>(config.asic().block_voxels())) {}

  Board& board() { return board_; }

  TransactionResult send(wire::FrameType type, const std::vector<std::uint8_t>& payload) {
    return send(type, next_id_++, payload);
  }
  TransactionResult send(wire::FrameType type, std::uint32_t id, const std::vector<std::uint8_t>& payload) {
    wire::FrameHeader header;
    header.type = type;
    header.id = id;
    header.time_ps = now_ps;
    return board_.transact(header, payload, work);
  }

  void write_register(std::uint32_t offset, std::uint32_t value) {
    std::vector<std::uint8_t> payload(8);
    wire::store(std::span(payload), 0, offset);
    wire::store(std::span(payload), 4, value);
    send(wire::FrameType::kRegisterWrite, payload);
  }

  std::uint32_t read_register(std::uint32_t offset) {
    std::vector<std::uint8_t> payload(4);
    wire::store(std::span(payload), 0, offset);
    const TransactionResult outcome = send(wire::FrameType::kRegisterRead, payload);
    now_ps = outcome.reply->time_ps;
    return wire::load<std::uint32_t>(outcome.reply->payload, 0);
  }

  void write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes) {
    std::vector<std::uint8_t> payload(8);
    wire::store(std::span(payload), 0, address);
    payload.insert(payload.end(), bytes.begin(), bytes.end());
    send(wire::FrameType::kMemoryWrite, payload);
  }

  Reply read_memory(std::uint64_t address, std::uint64_t length) {
    std::vector<std::uint8_t> payload(16);
    wire::store(std::span(payload), 0, address);
    wire::store(std::span(payload), 8, length);
    TransactionResult outcome = send(wire::FrameType::kMemoryRead, payload);
    now_ps = outcome.reply->time_ps;
    return *outcome.reply;
  }

  std::uint32_t next_ticket() const { return next_id_; }
  // The frame id of a command is its ticket.
  std::uint32_t command(const std::vector<std::uint8_t>& payload) {
    const std::uint32_t ticket = next_id_;
    send(wire::FrameType::kCommand, payload);
    return ticket;
  }

  TransactionResult wait(std::uint32_t ticket) {
    std::vector<std::uint8_t> payload(4);
    wire::store(std::span(payload), 0, ticket);
    TransactionResult outcome = send(wire::FrameType::kWait, payload);
    now_ps = outcome.reply->time_ps;
    return outcome;
  }

  void load_volume(const std::array<int, 3>& size, const VoxelField& field) {
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      write_register(wire::reg::kVolumeX + 4 * axis, static_cast<std::uint32_t>(size[axis]));
    const std::size_t words =
        static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_);
    std::uint64_t address = wire::kVolume.base;
    for (int bz = 0; bz * n_ < size[2]; ++bz) {
      for (int by = 0; by * n_ < size[1]; ++by) {
        for (int bx = 0; bx * n_ < size[0]; ++bx) {
          std::vector<std::uint8_t> block(wire::packed36_bytes(words));
          for (std::size_t i = 0; i < words; ++i) {
            const auto n = static_cast<std::size_t>(n_);
            const int x = bx * n_ + static_cast<int>(i % n), y = by * n_ + static_cast<int>(i / n % n),
                      z = bz * n_ + static_cast<int>(i / n / n);
            if (x < size[0] && y < size[1] && z < size[2]) wire::store36(block, i, wire::to_word(field(x, y, z)));
          }
          write_memory(address, block);
          address += block.size();
        }
      }
    }
  }

  void write_segmentation(const std::function<wire::SegmentationEntry(unsigned tag, unsigned density)>& entry) {
    std::vector<std::uint8_t> bytes(wire::kSegmentationLut.bytes);
    for (unsigned i = 0; i < wire::kSegmentationEntries; ++i) {
      wire::encode(entry(i >> 12, i & 0xFFF), std::span(bytes).subspan(i * wire::kSegmentationEntryBytes));
    }
    write_memory(wire::kSegmentationLut.base, bytes);
  }

  // Renders, waits and reads the image back; the test fails by exception if the board refuses.
  std::vector<wire::Pixel> render(const wire::RenderCommand& view) {
    std::vector<std::uint8_t> payload(wire::kRenderCommandBytes);
    wire::encode(view, payload);
    const TransactionResult outcome = wait(command(payload));
    const Completion& completion = outcome.completions.at(0);
    if (completion.error != wire::ErrorCode::kNone)
      throw std::runtime_error(std::string(completion.payload.begin(), completion.payload.end()));
    const std::size_t pixels = std::size_t{view.width} * static_cast<std::size_t>(wire::rows_of(view));
    const Reply reply = read_memory(wire::kFramebuffer.base, wire::packed36_bytes(pixels));
    std::vector<wire::Pixel> image(pixels);
    for (std::size_t i = 0; i < pixels; ++i) image[i] = wire::to_pixel(wire::load36(reply.payload, i));
    return image;
  }

  std::vector<wire::Ray> trace(const std::vector<wire::Ray>& rays, const wire::TraceHeader& header = {}) {
    const TransactionResult outcome = wait(command(trace_payload(rays, header)));
    return traced(outcome.completions.at(0));
  }

  // The header's count is set.
  static std::vector<std::uint8_t> trace_payload(const std::vector<wire::Ray>& rays, wire::TraceHeader header = {}) {
    std::vector<std::uint8_t> payload(wire::kTraceHeaderBytes + rays.size() * wire::kRayBytes);
    header.count = static_cast<std::uint32_t>(rays.size());
    wire::encode(header, payload);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      wire::encode(rays[i], std::span(payload).subspan(wire::kTraceHeaderBytes + i * wire::kRayBytes));
    }
    return payload;
  }

  static std::vector<wire::Ray> traced(const Completion& completion) {
    std::vector<wire::Ray> rays(completion.payload.size() / wire::kRayBytes);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      rays[i] = wire::decode<wire::Ray>(std::span(completion.payload).subspan(i * wire::kRayBytes));
    }
    return rays;
  }

  std::uint64_t held_bytes() const { return board_.held_bytes(); }
  std::uint64_t memory_bytes() const { return board_.memory_bytes(); }

  void add_memory_error(const MemoryError& error) { board_.add_memory_error(error); }

  Board::Snapshot snapshot() const { return board_.snapshot(); }
  std::uint64_t cycles_ahead() const {
    for (const wire::Counter& counter : board_.counters()) {
      if (counter.name == "emulator.cycles_ahead") return counter.value;
    }
    return 0;
  }
  // Those of the card.
  std::vector<wire::Counter> counters() const {
    std::vector<wire::Counter> list = board_.counters();
    std::erase_if(list, [](const wire::Counter& counter) { return counter.name == "emulator.cycles_ahead"; });
    return list;
  }
  std::uint64_t counter(const std::string& name) const {
    for (const wire::Counter& counter : board_.counters()) {
      if (counter.name == name) return counter.value;
    }
    throw std::runtime_error("no counter " + name);
  }

  std::uint64_t now_ps = 0;  // the host's clock
  Progress work;

 private:
  Board board_;
  int n_;
  std::uint32_t next_id_ = 1;
};

// A host ray in voxels; `direction` is normalised.
wire::Ray host_ray(std::uint32_t id, const std::array<double, 3>& position, const std::array<double, 3>& direction);

// A perspective view of a volume of `size` from outside a corner; square image.
wire::RenderCommand corner_view(const std::array<int, 3>& size, int image_size);

}  // namespace gicube::emu
