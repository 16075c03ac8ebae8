#include "board/saved/state_fields.h"

#include <fmt/format.h>

#include "gicube/wire/bytes.h"
#include "gicube/wire/checksum.h"

namespace gicube {
namespace {

using Bytes = std::span<const std::uint8_t>;

// A tag of checkpoint.proto: a field's number and its wire type.
constexpr std::uint8_t tag(unsigned number, unsigned manner) { return static_cast<std::uint8_t>(number << 3 | manner); }
constexpr unsigned kFixed32 = 5, kLength = 2;
constexpr std::uint8_t kHeader = tag(1, kLength), kStateField = tag(2, kLength), kChecksum = tag(3, kFixed32);
constexpr std::uint8_t kFieldOfDriver = tag(1, kLength);
constexpr std::uint8_t kName = tag(1, kLength), kNumbers = tag(2, kLength), kBytes = tag(3, kLength),
                       kText = tag(4, kLength);
constexpr std::size_t kChecksumBytes = 5;  // with its tag
constexpr const char* kPart = "host.driver";

void put_number(std::vector<std::uint8_t>& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80));
  out.push_back(static_cast<std::uint8_t>(value));
}

void put(std::vector<std::uint8_t>& out, std::uint8_t with_tag, Bytes bytes) {
  out.push_back(with_tag);
  put_number(out, bytes.size());
  out.insert(out.end(), bytes.begin(), bytes.end());
}

Bytes bytes_of(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

[[noreturn]] void malformed(const char* expected, std::size_t left) {
  throw CheckpointFault("fields", expected, fmt::format("other bytes, {} before the end", left));
}

std::uint64_t take_number(Bytes& rest) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !rest.empty(); shift += 7) {
    const std::uint8_t byte = rest[0];
    rest = rest.subspan(1);
    value |= std::uint64_t{byte & 0x7Fu} << shift;
    if (byte < 0x80) return value;
  }
  malformed("a whole number", rest.size());
}

// Takes the bytes of the field with that tag.
Bytes take(Bytes& rest, std::uint8_t with_tag) {
  if (rest.empty() || rest[0] != with_tag) malformed("another field", rest.size());
  rest = rest.subspan(1);
  const std::uint64_t size = take_number(rest);
  if (size > rest.size()) malformed("a whole field", rest.size());
  const Bytes bytes = rest.first(static_cast<std::size_t>(size));
  rest = rest.subspan(bytes.size());
  return bytes;
}

bool is_next(Bytes rest, std::uint8_t with_tag) { return !rest.empty() && rest[0] == with_tag; }

}  // namespace

void FieldWriter::exchange(Field& field) {
  std::vector<std::uint8_t> message, numbers;
  put(message, kName, bytes_of(field.name));
  for (const std::uint64_t each : field.numbers) put_number(numbers, each);
  if (!numbers.empty()) put(message, kNumbers, numbers);
  if (!field.bytes.empty()) put(message, kBytes, bytes_of(field.bytes));
  for (const std::string& each : field.texts) put(message, kText, bytes_of(each));
  put(bytes_, kFieldOfDriver, message);
}

void FieldReader::exchange(Field& field) {
  if (rest_.empty()) throw CheckpointFault(field.name, "a field of this name", "the end");
  Bytes message = take(rest_, kFieldOfDriver);
  const auto text_of = [](Bytes bytes) { return std::string(bytes.begin(), bytes.end()); };
  const std::string name = text_of(take(message, kName));
  if (name != field.name) throw CheckpointFault(field.name, "a field of this name", name);
  if (is_next(message, kNumbers)) {
    for (Bytes numbers = take(message, kNumbers); !numbers.empty();) field.numbers.push_back(take_number(numbers));
  }
  if (is_next(message, kBytes)) field.bytes = text_of(take(message, kBytes));
  field.texts.clear();
  while (is_next(message, kText)) field.texts.push_back(text_of(take(message, kText)));
  if (!message.empty()) malformed("no more of this field", message.size());
}

void FieldReader::end() const {
  if (!rest_.empty()) malformed("no more of them", rest_.size());
}

std::span<const std::uint8_t> driver_part(Bytes checkpoint) {
  const bool has_end =
      checkpoint.size() > kChecksumBytes && checkpoint[checkpoint.size() - kChecksumBytes] == kChecksum;
  if (!has_end) {
    throw CheckpointFault("file", "a checkpoint with its checksum", fmt::format("{} other bytes", checkpoint.size()));
  }
  Bytes rest = checkpoint.first(checkpoint.size() - kChecksumBytes);
  const auto wanted = wire::load<std::uint32_t>(checkpoint, rest.size() + 1), got = wire::crc32c(rest);
  if (got != wanted) {
    throw CheckpointFault("crc32c", fmt::format("{:08x} of a whole file", wanted), fmt::format("{:08x}", got));
  }
  take(rest, kHeader);
  while (is_next(rest, kStateField)) {
    Bytes message = take(rest, kStateField);
    const Bytes name = take(message, kName);
    if (std::string(name.begin(), name.end()) != kPart) continue;
    if (is_next(message, kBytes)) return take(message, kBytes);
    break;
  }
  throw CheckpointFault(kPart, "the state of a driver (Board::save())", "none");
}

}  // namespace gicube
