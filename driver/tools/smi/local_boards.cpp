#include "local_boards.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "client.h"
#include "gicube/registry.h"

namespace gicube::smi {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;

constexpr std::chrono::seconds kRegistryPatience{2};  // chosen: a running board answers within milliseconds

auto into(boost::system::error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

struct Asked {
  LocalProcess process;
  std::string path;
  bool gone = false;
};

asio::awaitable<void> ask(asio::io_context& io, Asked& asked) {
  asio::local::stream_protocol::socket socket(io);
  boost::system::error_code error;
  co_await socket.async_connect(asio::local::stream_protocol::endpoint(asked.path), into(error));
  asked.gone = error == asio::error::connection_refused || error == boost::system::errc::no_such_file_or_directory;
  if (error) co_return;
  std::string bytes;
  co_await asio::async_read(socket, asio::dynamic_buffer(bytes), into(error));
  v1::BoardProcess told;
  if (error == asio::error::eof && told.ParseFromString(bytes)) asked.process.told = std::move(told);
}

std::vector<Asked> sockets_of(const std::string& folder) {
  std::vector<Asked> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    Asked asked{{}, entry.path().string()};
    const auto [end, fault] = std::from_chars(name.data(), name.data() + name.size(), asked.process.pid);
    if (fault == std::errc{} && end == name.data() + name.size()) found.push_back(std::move(asked));
  }
  std::ranges::sort(found, {}, [](const Asked& asked) { return asked.process.pid; });
  return found;
}

}  // namespace

std::vector<LocalProcess> local_processes() {
  const std::string folder = registry_folder();
  std::error_code error;
  if (!fs::exists(fs::symlink_status(folder, error))) return {};  // no board has run yet
  if (const std::string fault = registry_fault(folder); !fault.empty()) throw CallFailed(fault);
  remove_dead_sockets(folder);
  std::vector<Asked> asked = sockets_of(folder);
  {
    asio::io_context io;
    for (Asked& each : asked) asio::co_spawn(io, ask(io, each), asio::detached);
    io.run_for(kRegistryPatience);
  }
  std::vector<LocalProcess> processes;
  for (Asked& each : asked) {
    if (!each.gone) processes.push_back(std::move(each.process));
  }
  return processes;
}

std::string only_management_endpoint() {
  std::vector<std::string> endpoints;
  for (const LocalProcess& process : local_processes()) {
    if (process.told && !process.told->management_endpoint().empty())
      endpoints.push_back(process.told->management_endpoint());
  }
  if (endpoints.size() == 1) return endpoints.front();
  throw UsageError(
      endpoints.empty()
          ? "--management: expected a management plane, got none, and no board of this user on this machine "
            "has one (gicube-board --management unix:PATH)"
          : fmt::format("--management: expected one of {}, got none", fmt::join(endpoints, ", ")));
}

}  // namespace gicube::smi
