#include "view/live_counters.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <utility>

#include "gicube/registry.h"
#include "gicube/v1/management.pb.h"

#include <boost/asio/local/stream_protocol.hpp>

namespace gicube::samples::view {
namespace {

constexpr std::chrono::milliseconds kEvery{100};     // as documented in protocol.h
constexpr std::chrono::milliseconds kPatience{500};  // chosen: a running board answers within milliseconds

std::optional<v1::BoardProcess> told_by(const std::string& path) try {
  using Local = boost::asio::local::stream_protocol;
  Local::iostream stream;
  stream.expires_after(kPatience);
  stream.connect(Local::endpoint(path));
  v1::BoardProcess process;
  return stream && process.ParseFromIstream(&stream) ? std::optional(std::move(process)) : std::nullopt;
} catch (const boost::system::system_error&) {
  return {};  // not a socket
}

bool is_child(const std::string& pid) {
  std::ifstream status("/proc/" + pid + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("PPid:")) return std::stol(line.substr(5)) == ::getpid();
  }
  return false;
}

using Json = nlohmann::ordered_json;

Json machine_of(const v1::MachineLook& look) {
  const auto list = [](const auto& values) { return Json(std::vector(values.begin(), values.end())); };
  Json memories;
  for (const v1::MemoryBanks& memory : look.memories()) memories.push_back(list(memory.packets()));
  return {{"blocks_a_side", look.blocks_a_side()}, {"cells", list(look.cells())}, {"waiting", list(look.waiting())},
          {"processors", list(look.processors())}, {"banks", look.banks()},       {"memories", std::move(memories)}};
}

BoardLook look_of(const v1::CounterSnapshot& snapshot) {
  std::vector<Counter> list;
  for (const v1::Counter& each : snapshot.counters()) list.push_back({each.name(), each.unit(), each.value()});
  return {static_cast<Picoseconds>(snapshot.simulated_ps()), Counters(std::move(list)),
          snapshot.has_machine() ? machine_of(snapshot.machine()) : Json(nullptr)};
}

}  // namespace

std::optional<BoardLook> look_at(const std::string& uri, std::uint64_t config_hash) {
  const std::string folder = registry_folder();
  if (!registry_fault(folder).empty()) return {};
  const std::string hash = fmt::format("{:016x}", config_hash);
  const bool is_own = uri.starts_with("emu:");
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string pid = entry.path().filename().string();
    if (pid.starts_with('.') || (is_own && !is_child(pid))) continue;
    const auto process = told_by(entry.path().string());
    for (int i = 0; process && i < process->boards_size() && i < process->counters_size(); ++i) {
      const v1::BoardInfo& board = process->boards(i);
      if (board.config_hash() == hash && (is_own || board.bus_endpoint() == uri)) return look_of(process->counters(i));
    }
  }
  return {};
}

LiveCounters::LiveCounters(Tell tell) : tell_(std::move(tell)), thread_([this] { work(); }) {}

LiveCounters::~LiveCounters() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void LiveCounters::listen(std::uint64_t page, bool on) {
  const std::lock_guard lock(mutex_);
  for (auto* pages : {&pages_, &new_pages_}) {
    if (on) {
      pages->insert(page);
    } else {
      pages->erase(page);
    }
  }
  wake_.notify_all();
}

void LiveCounters::show(const std::string& uri, std::uint64_t config_hash) {
  const std::lock_guard lock(mutex_);
  uri_ = uri;
  config_hash_ = config_hash;
  counted_.reset();
}

void LiveCounters::set_running(bool running) {
  const std::lock_guard lock(mutex_);
  running_ = running;
}

void LiveCounters::counted(const BoardLook& look) {
  const std::lock_guard lock(mutex_);
  counted_ = look;
}

void LiveCounters::work() {
  BoardLook last;
  bool was_running = false;
  std::unique_lock lock(mutex_);
  while (!ends_) {
    if (pages_.empty() || uri_.empty()) {
      wake_.wait_for(lock, kEvery * 10, [this] { return ends_ || (!pages_.empty() && !uri_.empty()); });
      continue;
    }
    const std::string uri = uri_;
    const std::uint64_t hash = config_hash_;
    const bool running = running_;
    lock.unlock();
    std::optional<BoardLook> seen = look_at(uri, hash);
    lock.lock();
    if (!seen && uri == uri_) seen = counted_;
    if (seen) {
      const bool is_new =
          running != was_running ||
          !std::ranges::equal(seen->counters.list(), last.counters.list(), {}, &Counter::value, &Counter::value) ||
          seen->machine != last.machine;
      const std::set<std::uint64_t> fresh = std::exchange(new_pages_, {});
      const std::set<std::uint64_t> pages = is_new ? pages_ : fresh;
      last = *seen;
      was_running = running;
      lock.unlock();
      for (const std::uint64_t page : pages) tell_(page, last, running, fresh.contains(page));
      lock.lock();
    }
    wake_.wait_for(lock, kEvery, [this] { return ends_; });
  }
}

}  // namespace gicube::samples::view
