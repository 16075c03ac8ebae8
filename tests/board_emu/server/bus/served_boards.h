// Boards behind a bus server on a thread of this process, and what clients of it send.
#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bare_board.h"
#include "raw_client.h"
#include "server/bus/bus_server.h"
#include "temporary_directory.h"

namespace gicube::emu {

inline BusOptions patient() {
  BusOptions options;
  options.handshake_deadline = std::chrono::minutes(1);  // a slow machine must not fail a test
  options.progress_interval = std::chrono::milliseconds(5);
  return options;
}

class ServedBoards {
 public:
  explicit ServedBoards(std::uint32_t boards = 1, const BusOptions& options = patient()) : server(options) {
    for (std::uint32_t i = 0; i < boards; ++i) {
      v1::BoardConfig config;
      config.set_threads(2);
      slots.push_back(std::make_unique<BoardSlot>(i, config));
      const Endpoint endpoint{EndpointKind::kUnix, path(i), "", 0, -1};
      server.listen(*slots.back(), endpoint);
    }
    start();
  }
  ~ServedBoards() { stop(); }
  ServedBoards(const ServedBoards&) = delete;
  ServedBoards& operator=(const ServedBoards&) = delete;

  std::string path(std::uint32_t board = 0) const { return folder.file("board" + std::to_string(board)); }
  reference::RawClient connect(std::uint32_t board = 0) const {
    return reference::RawClient::connect_unix(path(board));
  }
  // A client that owns the board.
  reference::RawClient open(const wire::VersionInfo& mine = {}, std::uint32_t board = 0) const {
    reference::RawClient client = connect(board);
    const auto answer = client.handshake(mine);
    if (!answer || answer->header.error != wire::ErrorCode::kNone) throw std::runtime_error("the board refused us");
    return client;
  }

  std::vector<BoardSlot*> all() const {
    std::vector<BoardSlot*> pointers;
    for (const auto& slot : slots) pointers.push_back(slot.get());
    return pointers;
  }

  void stop() {
    server.stop();
    if (thread_.joinable()) thread_.join();
  }

  reference::TemporaryDirectory folder;
  std::vector<std::unique_ptr<BoardSlot>> slots;
  BusServer server;

 private:
  void start() {
    thread_ = std::thread([this] { server.run(); });
  }

  std::thread thread_;
};

// A picture that takes minutes unless it is cancelled, in parts of some milliseconds.
inline void post_long_command(reference::RawClient& client, std::uint32_t ticket) {
  for (const std::uint32_t axis : {wire::reg::kVolumeX, wire::reg::kVolumeY, wire::reg::kVolumeZ}) {
    client.write_register(axis, 256);
  }
  client.write_register(wire::reg::kPipeline, 0);
  client.write_register(wire::reg::kStep, wire::kStepOne / 4);
  wire::RenderCommand view = corner_view({256, 256, 256}, 1024);
  view.samples_per_axis = 4;
  const auto payload = wire::encoded(view);
  client.send(wire::FrameType::kCommand, ticket, wire::kPosted, payload);
}

// The board answers and its state is that of power-up.
inline bool serves_afresh(const ServedBoards& boards, std::uint32_t board = 0) {
  wire::VersionInfo mine;
  mine.wait_ms = 10'000;  // until what the session before began has ended
  reference::RawClient client = boards.open(mine, board);
  return client.read_register(wire::reg::kId) == wire::kIdValue && client.read_register(wire::reg::kVolumeX) == 0;
}

}  // namespace gicube::emu
