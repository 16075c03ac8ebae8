// Sessions captured by the driver, and gicube-replay on them.
#include <zlib.h>

#include "board_process.h"
#include "full_disk.h"
#include "gicube/board.h"
#include "gicube/wire/capture.h"
#include "gicube/wire/checksum.h"
#include "run_program.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::tools_test {
namespace {

using reference::TemporaryDirectory;

void write(const std::string& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

Board open(const std::string& uri, const OpenOptions& options) { return Board::open(uri, options); }

// A volume, a picture, rays, counters: something of each kind of traffic.
void use(const std::string& uri, const OpenOptions& options = {}) {
  Board board = open(uri, options);
  std::vector<std::byte> samples(40 * 40 * 40);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<std::byte>(i % 251);
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {40, 40, 40}});
  board.set_transfer_function({.colours = {{0, {1.0, 0.6, 0.3}}}, .opacities = {{96, 0.0}, {160, 0.1}}});
  View view;
  view.width = view.height = 32;
  view.eye = {90, 70, -40};
  view.look_at = {20, 20, 20};
  board.render(view);
  const std::vector<HostRay> rays(50, {.id = 3, .position = {5, 6, 0}, .direction = {0, 0, 1}});
  board.receive(board.submit(rays));
  board.counters();
}

std::string captured(const TemporaryDirectory& folder, const std::string& uri = "emu:") {
  OpenOptions options;
  options.capture = folder.file("session.cap");
  use(uri, options);
  return options.capture;
}

Finished replay(const std::string& file, const std::string& board = "emu:") {
  return run_program("gicube-replay", {file, "--board", board});
}

// Changes the frames that `change` wants to, and seals them anew.
void alter(const std::string& file,
           const std::function<bool(wire::CaptureKind, wire::FrameHeader&, std::span<std::uint8_t>)>& change) {
  const std::string text = text_of(file);
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  std::size_t at = wire::kCaptureHeaderBytes;
  while (at + wire::kCaptureRecordBytes + wire::kFrameHeaderBytes <= bytes.size()) {
    const auto record = wire::decode<wire::CaptureRecord>(std::span(bytes).subspan(at));
    const auto head = std::span(bytes).subspan(at + wire::kCaptureRecordBytes).first<wire::kFrameHeaderBytes>();
    auto header = wire::decode_frame_header(head);
    ASSERT_TRUE(record.kind <= wire::CaptureKind::kEnd && header);
    const auto payload =
        std::span(bytes).subspan(at + wire::kCaptureRecordBytes + wire::kFrameHeaderBytes, header->size);
    if (change(record.kind, *header, payload)) wire::encode_sealed(*header, payload, head);
    at += wire::kCaptureRecordBytes + wire::kFrameHeaderBytes + header->size;
  }
  write(file, {bytes.begin(), bytes.end()});
}

TEST(Replay, TheSameMachineAnswersTheSameAtTheSameTimes) {
  const TemporaryDirectory folder;
  const Finished run = replay(captured(folder));
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("times and counters are compared too"), HasSubstr("no difference"),
                             ContainsRegex("compared [1-9][0-9]+ answers")));
}

TEST(Replay, AnotherMachineMakesTheSamePicturesAndRays) {
  const TemporaryDirectory folder;
  const Finished run = replay(captured(folder), "emu:?fidelity=cycle&bus=agp2x");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("another configuration"), HasSubstr("no difference")));
}

TEST(Replay, ASessionThatWasResumedReplaysAsIfNothingHadBeen) {
  const TemporaryDirectory folder;
  write(folder.file("plan"), "random { kinds: drop kinds: corrupt kinds: duplicate mean_messages: 8 seed: 3 }");
  system_test::BoardProcess process(
      {"--listen", "unix:" + folder.file("bus"), "--faults", folder.file("plan"), "--quiet"});
  ASSERT_THAT(process.read_line(), HasSubstr("ready"));
  OpenOptions options;
  options.capture = folder.file("session.cap");
  options.reopen_attempts = 100;
  use("unix:" + folder.file("bus"), options);
  std::map<std::uint32_t, int> times_sent;
  alter(options.capture, [&](wire::CaptureKind kind, wire::FrameHeader& header, std::span<std::uint8_t>) {
    if (kind == wire::CaptureKind::kDown && !wire::is_free(header.type)) ++times_sent[header.sequence];
    return false;
  });
  const bool sent_again =
      std::any_of(times_sent.begin(), times_sent.end(), [](const auto& frame) { return frame.second > 1; });
  EXPECT_TRUE(sent_again) << "the plan has lost nothing";
  const Finished run = replay(options.capture);
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("times and counters are compared too"), HasSubstr("no difference")));
}

TEST(Replay, TheUriAndTheEnvironmentNameTheFileToo) {
  const TemporaryDirectory folder;
  use("emu:?capture=" + folder.file("uri.cap"));
  EXPECT_EQ(replay(folder.file("uri.cap")).code, 0);
  const Finished hello = run_program("gicube-hello", {}, {"GICUBE_CAPTURE=" + folder.file("environment.cap")});
  EXPECT_EQ(hello.code, 0);
  EXPECT_EQ(replay(folder.file("environment.cap")).code, 0);
}

TEST(Replay, AFileThatCantBeWrittenIsAnErrorOfOpen) {
  OpenOptions options;
  options.capture = "/no/such/folder/session.cap";
  EXPECT_THROW(open("emu:", options), OpenFailed);
}

TEST(Replay, ASessionWhoseCaptureCannotBeWrittenEndsWithTheReason) {
  reference::on_full_disks("b", reference::kDiskBlock, [](const std::string& folder, const std::string& reason) {
    OpenOptions options;
    options.capture = folder + "/session.cap";
    options.reopen_attempts = 3;
    EXPECT_THROWS(DeviceLost, "capture: " + options.capture + ": " + reason, use("emu:", options));
    EXPECT_EQ(reference::files_in(folder).size(), 1u);
  });
}

TEST(Replay, NamesTheFirstByteThatDiffers) {
  const TemporaryDirectory folder;
  const std::string file = captured(folder);
  alter(file, [](wire::CaptureKind kind, wire::FrameHeader& header, std::span<std::uint8_t> payload) {
    const bool is_picture = kind == wire::CaptureKind::kUp && header.type == wire::FrameType::kMemoryRead;
    if (is_picture) payload[9] ^= 1;
    return is_picture;
  });
  const Finished run = replay(file);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, ContainsRegex("1 differences; the first: memory read [0-9]+ at [0-9]+ ps: byte 9 of 4608 is"));
}

TEST(Replay, NamesTheFirstTimeThatDiffers) {
  const TemporaryDirectory folder;
  const std::string file = captured(folder);
  alter(file, [](wire::CaptureKind kind, wire::FrameHeader& header, std::span<std::uint8_t>) {
    const bool is_completion = kind == wire::CaptureKind::kUp && header.type == wire::FrameType::kCompletion;
    if (is_completion) ++header.time_ps;
    return is_completion;
  });
  const Finished run = replay(file);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, ContainsRegex("the first: completion [0-9]+ at [0-9]+ ps: was at [0-9]+ ps"));
  EXPECT_EQ(replay(file, "emu:?bus=agp4x").code, 0) << "another machine has other times";
}

TEST(Replay, ReadsWhatIsThereOfACaptureWithoutAnEnd) {
  const TemporaryDirectory folder;
  const std::string file = captured(folder);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  const Finished run = replay(file);
  EXPECT_THAT(run.out, HasSubstr("the capture has no end"));
}

TEST(Replay, ReadsGzippedCaptures) {
  const TemporaryDirectory folder;
  const std::string bytes = text_of(captured(folder)), file = folder.file("session.cap.gz");
  const gzFile gz = ::gzopen(file.c_str(), "wb");
  ASSERT_EQ(::gzwrite(gz, bytes.data(), static_cast<unsigned>(bytes.size())), static_cast<int>(bytes.size()));
  ::gzclose(gz);
  EXPECT_LT(std::filesystem::file_size(file), bytes.size());
  EXPECT_EQ(replay(file).code, 0);
}

TEST(Replay, DamageIsNamedByItsByte) {
  const TemporaryDirectory folder;
  const std::string file = captured(folder);
  std::string bytes = text_of(file);
  bytes[wire::kCaptureHeaderBytes + wire::kCaptureRecordBytes + wire::kFrameHeaderBytes] ^= 1;
  write(file, bytes);
  const Finished run = replay(file);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, ContainsRegex("session.cap: byte [0-9]+: a frame with a wrong checksum"));
  write(file, "something else, longer than a header");
  EXPECT_THAT(replay(file).err, HasSubstr("expected a capture, got something else"));
  EXPECT_THAT(replay(folder.file("none")).err, HasSubstr("no such file"));
}

TEST(Replay, WrongUsageEndsWithTwo) {
  EXPECT_EQ(run_program("gicube-replay", {}).code, 2);
  EXPECT_EQ(replay("x", "usb:1").code, 2);
  EXPECT_EQ(run_program("gicube-replay", {"--help"}).code, 0);
}

}  // namespace
}  // namespace gicube::tools_test
