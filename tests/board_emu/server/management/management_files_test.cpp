// What the management service writes, traces and checkpoints: into its folder for them, and nowhere else.
#include "managed_boards.h"
#include "server/management/management.h"
#include "test.h"

namespace gicube::emu {
namespace {

using grpc::StatusCode;
using reference::RawClient;

grpc::Status set_trace(ManagedBoards& managed, const std::string& file) {
  Call call;
  v1::SetTraceRequest request;
  request.set_file(file);
  v1::TraceInfo info;
  return managed.stub->SetTrace(&call, request, &info);
}

TEST(ManagementFiles, WritesTracesInItsFolderForThemAndNowhereElse) {
  ManagedBoards managed;
  const std::string outside = managed.boards.folder.file("outside");
  for (const std::string& file : {outside, managed.traces() + "/../outside", std::string("sub/trace"),
                                  std::string(".."), std::string(".hidden"), managed.traces() + "/"}) {
    const grpc::Status status = set_trace(managed, file);
    EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT) << file;
    EXPECT_THAT(status.error_message(), HasSubstr("expected the name of a new file in " + managed.traces() + ", got"));
  }
  EXPECT_FALSE(std::filesystem::exists(outside));
  EXPECT_TRUE(set_trace(managed, "by_name").ok());
  EXPECT_TRUE(set_trace(managed, managed.traces() + "/by_path").ok());
  EXPECT_TRUE(set_trace(managed, "").ok());
  for (const char* name : {"/by_name", "/by_path"}) EXPECT_TRUE(std::filesystem::exists(managed.traces() + name));
  EXPECT_THAT(set_trace(managed, "by_name").error_message(), HasSubstr("expected the name of a new file, got"));
}

grpc::Status save(ManagedBoards& managed, const std::string& file, v1::CheckpointInfo& info) {
  Call call;
  v1::SaveCheckpointRequest request;
  request.set_file(file);
  return managed.stub->SaveCheckpoint(&call, request, &info);
}

// A board that begins with the checkpoint has what the session had written, at its time.
TEST(ManagementFiles, WritesACheckpointWhileASessionOwnsTheBoard) {
  ManagedBoards managed;
  RawClient client = managed.boards.open();
  client.write_register(wire::reg::kSeed, 4711);
  EXPECT_EQ(client.read_register(wire::reg::kSeed), 4711u);
  v1::CheckpointInfo info;
  const grpc::Status status = save(managed, "warm", info);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(info.file(), managed.traces() + "/warm");
  EXPECT_EQ(info.bytes(), std::filesystem::file_size(info.file()));
  EXPECT_GT(info.simulated_ps(), 0u);
  client.write_register(wire::reg::kSeed, 1);

  const auto checkpoint = std::make_shared<const Checkpoint>(Checkpoint::read(info.file()));
  BoardSlot second(0, checkpoint->header().config(), {}, nullptr, kUnlimitedMemory, checkpoint);
  EXPECT_EQ(second.counters().simulated_ps, info.simulated_ps());
  const auto seed = [&second] {
    std::vector<std::uint8_t> offset(4);
    wire::store(std::span(offset), 0, wire::reg::kSeed);
    wire::FrameHeader header;
    header.type = wire::FrameType::kRegisterRead;
    Progress work;
    return wire::load<std::uint32_t>(second.board().transact(header, offset, work).reply->payload, 0);
  };
  EXPECT_EQ(seed(), 4711u);
  std::string why;
  second.renew(why);  // as for the next session
  EXPECT_EQ(why, "");
  EXPECT_EQ(seed(), 4711u);
  EXPECT_EQ(second.configure("asic { queue_rays: 17 }", why), BoardSlot::Configured::kFaulty);
  EXPECT_EQ(why, "asic.queue_rays: expected 256, as in the checkpoint, got 17");
  EXPECT_EQ(second.configure("bus { model: agp4x }", why), BoardSlot::Configured::kDone);
  EXPECT_EQ(seed(), 4711u);
}

TEST(ManagementFiles, WritesCheckpointsInTheFolderForTracesAndOverNothing) {
  ManagedBoards managed;
  v1::CheckpointInfo info;
  for (const std::string& file :
       {managed.boards.folder.file("outside"), std::string("sub/warm"), std::string(".warm"), std::string()}) {
    const grpc::Status status = save(managed, file, info);
    EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT) << file;
    EXPECT_THAT(status.error_message(), HasSubstr("expected the name of a new file in " + managed.traces()));
  }
  EXPECT_TRUE(save(managed, "warm", info).ok());
  EXPECT_THAT(save(managed, "warm", info).error_message(), HasSubstr("file: expected a new one, got "));
  std::filesystem::create_symlink(managed.boards.folder.file("outside"), managed.traces() + "/link");
  EXPECT_THAT(save(managed, "link", info).error_message(), HasSubstr("file: expected a new one, got "));
  EXPECT_FALSE(std::filesystem::exists(managed.boards.folder.file("outside")));
  std::filesystem::remove(managed.traces() + "/link");
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& each : std::filesystem::directory_iterator(managed.traces())) ++files;
  EXPECT_EQ(files, 1u);
}

// "trace\0.txt" would have been noted as "trace?.txt", and written as "trace".
TEST(ManagementFiles, RefusesNamesThatItCouldNotNote) {
  ManagedBoards managed;
  v1::CheckpointInfo info;
  for (const std::string& file : {std::string("trace\0.txt", 10), std::string("\0", 1), std::string("a\nb"),
                                  managed.traces() + std::string("/warm\0", 6), std::string("a\x7f")}) {
    for (const grpc::Status& status : {set_trace(managed, file), save(managed, file, info)}) {
      EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
      EXPECT_EQ(status.error_message(), "file: expected a name without control characters, got one with them");
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(managed.traces()));
  EXPECT_TRUE(set_trace(managed, "r\xc3\xb6ntgen").ok());
}

TEST(ManagementFiles, WithoutAFolderForThemItWritesNoTraces) {
  EXPECT_THROW(trace_path("", "trace"), std::invalid_argument);
}

}  // namespace
}  // namespace gicube::emu
