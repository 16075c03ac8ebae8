#include "host.h"

#include <algorithm>

#include "gicube/wire/counter_list.h"
#include "transport/connect.h"

namespace gicube::conformance {
namespace {

// Pieces of a long transfer are multiples of this, so that none ends within a dword, within a table's entry of 12 bytes
// or within a pair of voxels.
constexpr std::size_t kPiece = 36;

template <typename Word>
Bytes stored(std::initializer_list<Word> values) {
  Bytes bytes(sizeof(Word) * values.size());
  std::size_t at = 0;
  for (const Word value : values) wire::store(std::span(bytes), sizeof(Word) * at++, value);
  return bytes;
}

}  // namespace

Bytes words(std::initializer_list<std::uint32_t> values) { return stored(values); }
Bytes long_words(std::initializer_list<std::uint64_t> values) { return stored(values); }

RawFrame next_answer(RawClient& client) {
  auto answer = client.receive_answer();
  check(answer.has_value(), "expected an answer, the board closed the connection");
  return std::move(*answer);
}

RawFrame call(RawClient& client, FrameType type, std::uint32_t id, const Bytes& payload) {
  client.send(type, id, 0, payload);
  return next_answer(client);
}

wire::VersionInfo host_version() {
  wire::VersionInfo mine;
  mine.capabilities = wire::kFunctionalLevel | wire::kCycleLevel | wire::kHostRays;
  mine.wait_ms = 20'000;
  return mine;
}

RawFrame shake_hands(RawClient& client, const wire::VersionInfo& mine) {
  const auto answer = client.handshake(mine, access_token(client.socket(), false, {}));
  check(answer.has_value(), "expected an answer to kVersion, the board closed the connection");
  check_same("the answer's type", answer->header.type, FrameType::kVersion);
  check_same("the answer's flags", answer->header.flags, std::uint16_t{wire::kResponse});
  check_same("kVersion's number", answer->header.sequence, 0);
  return *answer;
}

Host::Host(Place& place, const wire::VersionInfo& mine)
    : place_(place), mine_(mine), client_(place.connect()), window_(mine) {
  const RawFrame answer = shake_hands(client_, mine);
  check(answer.header.error == ErrorCode::kNone, "expected a session, got error {}: {}",
        fmt::underlying(answer.header.error), answer.text());
  check(answer.payload.size() >= wire::kVersionBytes, "kVersion: expected 56 bytes, got {}", answer.payload.size());
  board_ = wire::decode<wire::VersionInfo>(answer.payload);
  window_.open(board_);
}

Host::~Host() {
  if (!ended_) client_.send(FrameType::kVersion, 0, wire::kPosted, {});
}

void Host::return_credit() { client_.send(window_.credit_frame(wire::kPosted)); }

std::uint32_t Host::post(FrameType type, const Bytes& payload, std::uint16_t flags) {
  while (!window_.can_send(payload.size())) {
    const auto frame = client_.receive();
    check(frame && frame->header.type == FrameType::kCredit, "expected credit for {} bytes, got none", payload.size());
    check(window_.take_credit(frame->header), "credit: more than was sent came back");
  }
  FrameHeader header{type, flags, ++last_id_};
  header.time_ps = now;
  header = window_.keep(header, wire::share(payload)).header;
  window_.put_credit(header);
  client_.send(header, payload);
  return header.id;
}

RawFrame Host::receive() {
  for (;;) {
    auto frame = client_.receive();
    check(frame.has_value(), "expected a frame, the board closed the connection");
    const FrameHeader& header = frame->header;
    if (header.type == FrameType::kVersion) {
      throw Failure(
          fmt::format("the board ended the session: error {}: {}", fmt::underlying(header.error), frame->text()));
    }
    check(window_.take_credit(header), "credit: {} frames and {} bytes came back, which were not sent",
          header.credit_slots, header.credit_bytes);
    if (header.type == FrameType::kProgress) continue;
    check(window_.arrival(header) == wire::ReliableWindow::Arrival::kNext, "expected frame {}, got {} of type {}",
          window_.taken() + 1, header.type == FrameType::kCredit ? header.id : header.sequence,
          fmt::underlying(header.type));
    if (header.type == FrameType::kCredit) continue;
    window_.take();
    check(window_.accept(header.size), "expected at most the window of {} frames and {} bytes in flight",
          mine_.window_slots, mine_.window_bytes);
    window_.consume(header.size);
    check(header.time_ps >= last_time_, "expected a time from {} ps on, got {}", last_time_, header.time_ps);
    last_time_ = header.time_ps;
    if (window_.credit_is_due()) return_credit();
    return std::move(*frame);
  }
}

RawFrame Host::ask(FrameType type, const Bytes& payload) {
  const std::uint64_t asked = now;
  const std::uint32_t id = post(type, payload, 0);
  for (;;) {
    RawFrame frame = receive();
    if (frame.header.type == FrameType::kCompletion) {
      check_same("a completion's flags", frame.header.flags, std::uint16_t{wire::kPosted});
      completions.push_back(std::move(frame));
      continue;
    }
    check_same("the response's type", frame.header.type, type);
    check_same("the response's flags", frame.header.flags, std::uint16_t{wire::kResponse});
    check_same("the response's id", frame.header.id, id);
    check(frame.header.time_ps >= asked, "expected an answer from {} ps on, got {} ps", asked, frame.header.time_ps);
    check(frame.header.error == ErrorCode::kNone || !frame.payload.empty(), "expected a text with error {}, got none",
          fmt::underlying(frame.header.error));
    now = frame.header.time_ps;
    return frame;
  }
}

Bytes Host::request(FrameType type, const Bytes& payload) {
  RawFrame answer = ask(type, payload);
  check(answer.header.error == ErrorCode::kNone, "expected an answer to a frame of type {}, got error {}: {}",
        fmt::underlying(type), fmt::underlying(answer.header.error), answer.text());
  return std::move(answer.payload);
}

RawFrame Host::refused_request(FrameType type, const Bytes& payload, ErrorCode error) {
  RawFrame answer = ask(type, payload);
  check(answer.header.error == error, "a frame of type {} with {} bytes: expected error {}, got {}",
        fmt::underlying(type), payload.size(), fmt::underlying(error), fmt::underlying(answer.header.error));
  return answer;
}

std::uint32_t Host::read_register(std::uint32_t offset) {
  const Bytes value = request(FrameType::kRegisterRead, words({offset}));
  check_same("bytes of a register", value.size(), 4);
  return wire::load<std::uint32_t>(value, 0);
}

std::uint32_t Host::read_config(std::uint32_t offset) {
  const Bytes value = request(FrameType::kConfigRead, words({offset}));
  check_same("bytes of a configuration dword", value.size(), 4);
  return wire::load<std::uint32_t>(value, 0);
}

void Host::write_register(std::uint32_t offset, std::uint32_t value) {
  post(FrameType::kRegisterWrite, words({offset, value}));
}

void Host::write_memory(std::uint64_t address, const Bytes& bytes) {
  const std::size_t most = (max_payload() - 8) / kPiece * kPiece;
  for (std::size_t at = 0; at < bytes.size(); at += most) {
    Bytes payload = long_words({address + at});
    const auto part = std::span(bytes).subspan(at, std::min(most, bytes.size() - at));
    payload.insert(payload.end(), part.begin(), part.end());
    post(FrameType::kMemoryWrite, payload);
  }
}

Bytes Host::read_memory(std::uint64_t address, std::uint64_t length) {
  const std::size_t most = max_payload() / kPiece * kPiece;
  Bytes all;
  while (all.size() < length) {
    const std::uint64_t size = std::min<std::uint64_t>(most, length - all.size());
    const Bytes part = request(FrameType::kMemoryRead, long_words({address + all.size(), size}));
    check_same("bytes of a memory read", part.size(), size);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

std::uint64_t Host::counter(const std::string& name) {
  const auto list = wire::decode_counters(request(FrameType::kCounters, {}));
  check(list.has_value(), "expected a counter list, got one that is cut short");
  const auto found = std::ranges::find(*list, name, &wire::Counter::name);
  return found == list->end() ? 0 : found->value;
}

RawFrame Host::completion(std::uint32_t ticket) {
  const auto is_its = [ticket](const RawFrame& frame) { return frame.header.id == ticket; };
  if (std::ranges::none_of(completions, is_its)) request(FrameType::kWait, words({ticket}));
  const auto found = std::ranges::find_if(completions, is_its);
  check(found != completions.end(), "expected a completion before the answer to kWait, got none");
  RawFrame frame = std::move(*found);
  completions.erase(found);
  return frame;
}

Bytes Host::run(const Bytes& payload) {
  RawFrame done = completion(command(payload));
  check(done.header.error == ErrorCode::kNone, "expected command {} to succeed, got error {}: {}",
        wire::load<std::uint32_t>(payload, 0), fmt::underlying(done.header.error), done.text());
  return std::move(done.payload);
}

void Host::refused(const Bytes& payload, const std::string& word) {
  const RawFrame done = completion(command(payload));
  check_same(word.c_str(), done.header.error, ErrorCode::kBadValue);
  check(done.text().find(word) != std::string::npos, "expected a text that names \"{}\", got \"{}\"", word,
        done.text());
  check((read_register(reg::kStatus) & wire::kStatusBadCommand) != 0, "{}: expected STATUS.bad_command", word);
  write_register(reg::kStatusClear, ~0u);
}

void Host::ends(RawClient& client, ErrorCode error, std::optional<std::uint32_t> id) {
  for (;;) {
    const auto frame = client.receive();
    check(frame.has_value(), "expected a last frame with error {}, the connection was closed", fmt::underlying(error));
    if (frame->header.type != FrameType::kVersion) continue;
    check_same("the last frame's flags", frame->header.flags, std::uint16_t{wire::kResponse});
    check_same("the last frame's error", frame->header.error, error);
    check(!frame->payload.empty(), "expected a text with the last frame, got none");
    if (id) check_same("the last frame's id", frame->header.id, *id);
    break;
  }
  check(!client.receive().has_value(), "expected the board to close the connection after its last frame");
}

}  // namespace gicube::conformance
