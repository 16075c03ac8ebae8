#include "board/checkpoint.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "gicube/whole_file.h"
#include "gicube/wire/bytes.h"
#include "gicube/wire/checksum.h"

namespace gicube::emu {

namespace {

using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;

constexpr const char* kFormat = "gicube checkpoint";
constexpr std::uint32_t kVersion = 1;
constexpr std::uint8_t kHeaderTag = 1 << 3 | 2, kFieldTag = 2 << 3 | 2, kChecksumTag = 3 << 3 | 5;
constexpr std::size_t kChecksumBytes = 5;  // including its tag
constexpr std::string_view kLevel = "level.", kAround = "host.";

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

class SavingArchive : public Archive {
 public:
  explicit SavingArchive(const std::function<void(std::string_view)>& sink) : Archive(false), sink_(sink) {}

  void put(std::string_view bytes) {
    checksum_ = wire::crc32c(bytes_of(bytes), checksum_);
    sink_(bytes);
  }
  void put(std::uint8_t tag, const google::protobuf::MessageLite& message) {
    const std::string bytes = message.SerializeAsString();
    std::array<std::uint8_t, 6> head{tag};
    const auto* const end =
        CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(bytes.size()), head.data() + 1);
    put({reinterpret_cast<const char*>(head.data()), static_cast<std::size_t>(end - head.data())});
    put(bytes);
  }
  void end() {
    std::array<std::uint8_t, kChecksumBytes> last{kChecksumTag};
    wire::store(std::span(last), 1, checksum_);
    sink_({reinterpret_cast<const char*>(last.data()), last.size()});
  }

 private:
  void exchange(Field& field) override {
    v1::StateField message;
    message.set_name(field.name);
    message.mutable_numbers()->Add(field.numbers.begin(), field.numbers.end());
    message.set_bytes(std::move(field.bytes));
    for (std::string& text : field.texts) *message.add_texts() = std::move(text);
    put(kFieldTag, message);
  }

  const std::function<void(std::string_view)>& sink_;
  std::uint32_t checksum_ = 0;
};

// Removes one message from the front of `rest`.
template <typename Message>
Message take(std::string_view& rest, std::uint8_t tag, const char* what) {
  Message message;
  std::uint32_t length = 0;
  std::size_t head = 0;
  if (!rest.empty() && static_cast<std::uint8_t>(rest[0]) == tag) {
    CodedInputStream in(reinterpret_cast<const std::uint8_t*>(rest.data()) + 1,
                        static_cast<int>(std::min<std::size_t>(rest.size() - 1, 5)));
    if (in.ReadVarint32(&length)) head = 1 + static_cast<std::size_t>(in.CurrentPosition());
  }
  const bool whole = head != 0 && length <= rest.size() - head;
  if (!whole || !message.ParseFromArray(rest.data() + head, static_cast<int>(length))) {
    throw CheckpointFault(what, "a whole message of its own", "something else");
  }
  rest.remove_prefix(head + length);
  return message;
}

class LoadingArchive : public Archive {
 public:
  explicit LoadingArchive(std::string_view fields) : Archive(true), rest_(fields) {}

  // Whether the next field belongs to the surroundings of the board.
  bool is_around() const {
    std::string_view rest = rest_;
    return !rest.empty() && take<v1::StateField>(rest, kFieldTag, "fields").name().starts_with(kAround);
  }
  void skip_around() {
    while (is_around()) take<v1::StateField>(rest_, kFieldTag, "fields");
  }
  // Checks that all fields were read, except possibly those of the level.
  void end(bool with_level) {
    while (!rest_.empty()) {
      const auto message = take<v1::StateField>(rest_, kFieldTag, "fields");
      const bool skipped = !with_level && message.name().starts_with(kLevel);
      if (!skipped) throw CheckpointFault("fields", "no more of them", message.name());
    }
  }

 private:
  void exchange(Field& field) override {
    if (rest_.empty()) throw CheckpointFault(field.name, "a field of this name", "the end");
    auto message = take<v1::StateField>(rest_, kFieldTag, "fields");
    if (message.name() != field.name) throw CheckpointFault(field.name, "a field of this name", message.name());
    field.numbers.assign(message.numbers().begin(), message.numbers().end());
    field.bytes = std::move(*message.mutable_bytes());
    field.texts.assign(message.texts().begin(), message.texts().end());
  }

  std::string_view rest_;
};

void compare(const google::protobuf::Message& saved, const google::protobuf::Message& wanted, const std::string& path,
             bool in_command, std::vector<Diagnostic>& faults) {
  static constexpr std::array kAlwaysFree{"threads", "pace", "bus"};
  static constexpr std::array kFree{"fidelity", "link", "sorter.policy", "dsp.run_rays", "dsp.run_error"};
  const google::protobuf::Reflection& reflection = *saved.GetReflection();
  for (int i = 0; i < saved.GetDescriptor()->field_count(); ++i) {
    const google::protobuf::FieldDescriptor* const field = saved.GetDescriptor()->field(i);
    const std::string name = path + std::string(field->name());
    if (std::ranges::find(kAlwaysFree, name) != kAlwaysFree.end()) continue;
    if (!in_command && std::ranges::find(kFree, name) != kFree.end()) continue;
    if (field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) {
      compare(reflection.GetMessage(saved, field), reflection.GetMessage(wanted, field), name + '.', in_command,
              faults);
      continue;
    }
    std::string before, after;
    google::protobuf::TextFormat::PrintFieldValueToString(saved, field, -1, &before);
    google::protobuf::TextFormat::PrintFieldValueToString(wanted, field, -1, &after);
    if (before != after) faults.push_back({name, before + ", as in the checkpoint", after});
  }
}

}  // namespace

void save_checkpoint(Board& board, const std::function<void(std::string_view)>& sink, const Surroundings& around) {
  SavingArchive archive(sink);
  v1::CheckpointHeader header;
  header.set_format(kFormat);
  header.set_version(kVersion);
  header.set_product(GICUBE_VERSION);
  *header.mutable_config() = board.config();
  header.set_config_hash(config_hash(board.config()));
  header.set_simulated_ps(board.simulated_ps());
  header.set_in_command(board.in_command());
  archive.put(kHeaderTag, header);
  if (around) around(archive);
  board.state(archive);
  archive.end();
}

void save_checkpoint(Board& board, const std::filesystem::path& file, const Surroundings& around) {
  WholeFile out(file);
  save_checkpoint(
      board, [&out](std::string_view bytes) { out.write(bytes); }, around);
  out.commit();
}

std::vector<Diagnostic> fork_faults(const v1::BoardConfig& saved, const v1::BoardConfig& wanted, bool in_command) {
  std::vector<Diagnostic> faults;
  compare(resolve(saved), resolve(wanted), "", in_command, faults);
  return faults;
}

Checkpoint::Checkpoint(std::string bytes) : bytes_(std::move(bytes)) {
  const std::string_view all = bytes_;
  const bool has_end =
      all.size() > kChecksumBytes && static_cast<std::uint8_t>(all[all.size() - kChecksumBytes]) == kChecksumTag;
  if (!has_end)
    throw CheckpointFault("file", "a checkpoint with its checksum", fmt::format("{} other bytes", all.size()));
  const std::string_view before = all.substr(0, all.size() - kChecksumBytes);
  const std::uint32_t wanted = wire::load<std::uint32_t>(bytes_of(all), all.size() - kChecksumBytes + 1);
  const std::uint32_t got = wire::crc32c(bytes_of(before));
  if (got != wanted) {
    throw CheckpointFault("crc32c", fmt::format("{:08x} of a whole file", wanted), fmt::format("{:08x}", got));
  }
  std::string_view rest = before;
  header_ = take<v1::CheckpointHeader>(rest, kHeaderTag, "header");
  first_field_ = before.size() - rest.size();
  if (header_.format() != kFormat) throw CheckpointFault("header.format", kFormat, header_.format());
  if (header_.version() != kVersion) {
    throw CheckpointFault("header.version", std::to_string(kVersion),
                          fmt::format("{} of SDK {}", header_.version(), header_.product()));
  }
  const std::vector<Diagnostic> faults = check(header_.config());
  if (!faults.empty()) throw CheckpointFault("header.config: " + to_string(faults));
}

Checkpoint Checkpoint::read(const std::filesystem::path& file) {
  const auto size = static_cast<std::size_t>(std::filesystem::file_size(file));  // fails unless it is a regular file
  std::string bytes(size, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size))) {
    throw std::system_error(std::make_error_code(std::errc::io_error), file.string());
  }
  return Checkpoint(std::move(bytes));
}

std::string_view Checkpoint::fields() const {
  return std::string_view(bytes_).substr(first_field_, bytes_.size() - kChecksumBytes - first_field_);
}

void Checkpoint::surroundings(const Surroundings& around) const {
  LoadingArchive archive(fields());
  if (!archive.is_around()) return;
  around(archive);
  if (archive.is_around()) throw CheckpointFault("fields", "no more below host.", "another");
}

void Checkpoint::restore(Board& board) const {
  const std::vector<Diagnostic> faults = fork_faults(header_.config(), board.config(), header_.in_command());
  if (!faults.empty()) throw CheckpointFault("config." + to_string(faults));
  const bool with_level = header_.config().fidelity() == board.config().fidelity();
  LoadingArchive archive(fields());
  archive.skip_around();
  board.state(archive, with_level);
  archive.end(with_level);
  if (board.in_command() != header_.in_command()) {
    throw CheckpointFault("header.in_command", board.in_command() ? "1" : "0", header_.in_command() ? "1" : "0");
  }
}

}  // namespace gicube::emu
