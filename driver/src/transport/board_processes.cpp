#include "board_processes.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <list>
#include <system_error>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>

#include "gicube/error.h"
#include "gicube/registry.h"

namespace gicube {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;

constexpr std::chrono::seconds kAnswerPatience{2};             // chosen: a running board answers in milliseconds
constexpr std::size_t kLongestAnswer = std::size_t{16} << 20;  // chosen: 64 boards with all counters take 1% of it

struct AskedProcess {
  explicit AskedProcess(asio::io_context& io) : socket(io) {}

  BoardProcess process;
  asio::local::stream_protocol::socket socket;
  std::string bytes{};
  bool has_ended = false;

  void ask(const std::string& path) {
    socket.async_connect(path, [this](const boost::system::error_code& error) {
      has_ended = error == asio::error::connection_refused || error == boost::system::errc::no_such_file_or_directory;
      if (error) return;
      asio::async_read(socket, asio::dynamic_buffer(bytes, kLongestAnswer),
                       [this](const boost::system::error_code& end, std::size_t) {
                         if (end == asio::error::eof) process.answer = std::move(bytes);
                       });
    });
  }
};

}  // namespace

std::vector<BoardProcess> board_processes() {
  const std::string folder = registry_folder();
  std::error_code error;
  if (!fs::exists(fs::symlink_status(folder, error))) return {};  // no board has run so far
  if (const std::string fault = registry_fault(folder); !fault.empty()) throw Error(fault);
  remove_dead_sockets(folder);
  asio::io_context io;
  std::list<AskedProcess> asked;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    std::uint32_t id = 0;
    const auto [end, fault] = std::from_chars(name.data(), name.data() + name.size(), id);
    if (fault != std::errc{} || end != name.data() + name.size()) continue;
    asked.emplace_back(io).process.id = id;
    asked.back().ask(entry.path().string());
  }
  io.run_for(kAnswerPatience);
  std::vector<BoardProcess> processes;
  for (AskedProcess& each : asked) {
    if (!each.has_ended) processes.push_back(std::move(each.process));
  }
  std::ranges::sort(processes, {}, &BoardProcess::id);
  return processes;
}

}  // namespace gicube
