#include "device.h"

#include <fmt/format.h>

#include <utility>

#include "board/deadline.h"
#include "gicube/wire/counter_list.h"
#include "transport/connect.h"

namespace gicube {
namespace {

constexpr std::chrono::seconds kObituary{1};  // chosen: for a child that has closed its socket to end

// Pieces of memory writes are multiples of this: whole dwords, segmentation entries (12 bytes) and pairs of voxels (9).
constexpr std::size_t kPiece = 36;

// The address of a lost board, and advice.
std::string advice(const Uri& uri, Loss cause) {
  const std::string place = text_of(uri);
  if (cause == Loss::kTakenOver || cause == Loss::kEnded) return place;
  return fmt::format("{0}; Board::reopen() connects again, gicube-smi doctor {0} says why it can't", place);
}

std::vector<std::uint8_t> words(std::initializer_list<std::uint32_t> values) {
  std::vector<std::uint8_t> bytes(4 * values.size());
  std::size_t at = 0;
  for (const std::uint32_t value : values) {
    wire::store(std::span(bytes), at, value);
    at += 4;
  }
  return bytes;
}

}  // namespace

Device::Device(const Uri& uri, const OpenOptions& options, std::function<void()> while_waiting)
    : uri_(uri), capture_file_(options.capture.empty() ? uri.capture : options.capture) {
  link_options_.watchdog = options.watchdog;
  link_options_.reopen_attempts = options.reopen_attempts;
  link_options_.while_waiting = std::move(while_waiting);
  link_options_.log = options.log;
  if (options.force) link_options_.mine.flags |= wire::kForce;
  link_options_.mine.wait_ms = static_cast<std::uint32_t>(options.wait_for_board.count());
  if (uri_.scheme != UriScheme::kEmu) {
    // Throws BadArgument if the token file can't be used.
    if (uri_.scheme == UriScheme::kTcp || uri_.scheme == UriScheme::kPci) named_token(options.token_file);
    if (uri_.is_secure) link_options_.tls = make_tls(uri_.host, options.ca_file);
    link_options_.token = [this, token_file = options.token_file](int socket) {
      try {
        if (uri_.scheme == UriScheme::kPci) return named_token(token_file);  // the board's address is unknown here
        return access_token(socket, uri_.is_secure, token_file);
      } catch (const BadArgument&) {  // the board then asks for a token
        return std::string();
      }
    };
    link_options_.reconnect = [this] {
      if (uri_.scheme != UriScheme::kPci) return connect(uri_, link_options_.watchdog);
      function_.reset();  // a function has only one session
      function_ = std::make_unique<PciFunction>(uri_.path);
      return function_->take_socket();
    };
  }
  link_ = open_link();
}

std::shared_ptr<Link> Device::open_link() {
  link_options_.tap = capture_session(capture_file_, captures_++);
  if (link_options_.reconnect) return std::make_shared<Link>(link_options_.reconnect(), link_options_);
  child_ = std::make_unique<ChildProcess>(find_board_program(), uri_.board_arguments);
  try {
    return std::make_shared<Link>(child_->take_socket(), link_options_);
  } catch (const OpenFailed&) {
    if (!child_->ended(kObituary)) throw;
    if (const auto fault = child_->usage_fault()) {
      throw BadArgument("URI options", "values that gicube-board accepts", "some that it refuses:\n" + *fault);
    }
    throw OpenFailed(child_->last_words());
  }
}

bool Device::reopen() {
  if (link_options_.reconnect) {
    if (link_->resume()) return true;
    link_ = open_link();
    return false;
  }
  if (!link_->is_broken()) return true;
  auto lost = std::move(child_);  // destroyed after its link, which it waits for
  auto fresh = open_link();
  link_ = std::move(fresh);
  return false;
}

// Adds to DeviceLost why a private board ended, or advice for another one.
auto Device::with_last_words(const auto& call) const {
  try {
    return call();
  } catch (const DeviceLost& error) {
    if (!child_) throw DeviceLost(fmt::format("{} ({})", error.what(), advice(uri_, error.cause())), error.cause());
    if (!child_->ended(kObituary)) throw;
    throw DeviceLost(fmt::format("{}; {}", error.what(), child_->last_words()), error.cause());
  }
}

void Device::need_minor(std::uint16_t minor, const char* what) const {
  if (agreed().minor >= minor) return;
  throw Unsupported(fmt::format("{} a board of protocol 2.{}, this one has 2.{}", what, minor, agreed().minor));
}

void Device::check() {
  with_last_words([&] { link_->check(); });
}

std::vector<std::uint8_t> Device::request(wire::FrameType type, std::vector<std::uint8_t> payload) {
  Response response = with_last_words([&] { return link_->request(type, clock_.now(), std::move(payload)); });
  clock_.wait_until(response.time_ps);
  return std::move(response.payload);
}

std::uint32_t Device::read_word(wire::FrameType type, std::uint32_t offset) {
  const auto payload = request(type, words({offset}));
  if (payload.size() != 4) give_up(fmt::format("the board answered a register read with {} bytes", payload.size()));
  return wire::load<std::uint32_t>(payload, 0);
}

void Device::write_register(std::uint32_t offset, std::uint32_t value) {
  with_last_words([&] { link_->post(wire::FrameType::kRegisterWrite, clock_.now(), words({offset, value})); });
  registers_[offset] = value;
}

void Device::write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kAddressBytes = 8;
  const std::size_t piece = (agreed().max_payload_bytes - kAddressBytes) / kPiece * kPiece;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(bytes.size(), piece));
    std::vector<std::uint8_t> payload(kAddressBytes + part.size());
    wire::store(std::span(payload), 0, address);
    std::copy(part.begin(), part.end(), payload.begin() + kAddressBytes);
    with_last_words([&] { link_->post(wire::FrameType::kMemoryWrite, clock_.now(), std::move(payload)); });
    bytes = bytes.subspan(part.size());
    address += part.size();
  }
}

std::vector<std::uint8_t> Device::read_memory(std::uint64_t address, std::uint64_t length, std::size_t record) {
  const std::uint64_t most = agreed().max_payload_bytes / record * record;
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < length) {
    const std::uint64_t wanted = std::min(most, length - bytes.size());
    std::vector<std::uint8_t> payload(16);
    wire::store(std::span(payload), 0, address + bytes.size());
    wire::store(std::span(payload), 8, wanted);
    auto piece = request(wire::FrameType::kMemoryRead, std::move(payload));
    if (piece.size() != wanted) {
      give_up(fmt::format("the board answered a read of {} bytes with {}", wanted, piece.size()));
    }
    if (piece.size() == length) return piece;
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  }
  return bytes;
}

std::uint32_t Device::command(wire::Payload payload) {
  return with_last_words([&] { return link_->command(clock_.now(), payload); });
}

CommandResult Device::finish(std::uint32_t ticket, const Progress& progress, Picoseconds deadline) {
  const Response response = with_last_words([&] { return link_->wait(ticket, clock_.now(), deadline, progress); });
  clock_.wait_until(response.time_ps);
  if (response.error == wire::ErrorCode::kDeadline) throw deadline_passed(deadline);
  auto result = link_->take(ticket);
  if (!result) give_up("the board reported that a command has completed, without its result");
  clock_.wait_until(result->time_ps);
  return std::move(*result);
}

CommandResult Device::finish_or_throw(std::uint32_t ticket, const Progress& progress, Picoseconds deadline) {
  CommandResult result = finish(ticket, progress, deadline);
  if (result.error != wire::ErrorCode::kNone) throw_error(result.error, error_text(result.payload));
  return result;
}

CommandResult Device::run(std::vector<std::uint8_t> payload, const Progress& progress, Picoseconds deadline) {
  const std::uint32_t ticket = command(wire::share(std::move(payload)));
  try {
    return finish_or_throw(ticket, progress, deadline);
  } catch (...) {  // also what the progress callback throws
    link_->forget(ticket);
    throw;
  }
}

Device::Mark Device::mark() {
  return {link_, with_last_words([&] { return link_->begin(wire::FrameType::kPoll, clock_.now(), {}); })};
}

bool Device::cancel(std::uint32_t ticket) {
  const auto answer = request(wire::FrameType::kCancel, words({ticket}));
  if (answer.size() != 4) give_up(fmt::format("the board answered a cancel with {} bytes", answer.size()));
  return wire::load<std::uint32_t>(answer, 0) != 0;
}

Counters Device::counters() {
  const auto list = wire::decode_counters(request(wire::FrameType::kCounters, {}));
  if (!list) give_up("the board sent a truncated list of counters");
  std::vector<Counter> counters;
  for (const wire::Counter& counter : *list) counters.push_back({counter.name, counter.unit, counter.value});
  return Counters(std::move(counters));
}

}  // namespace gicube
