// The management service, called by a real client.
#include "server/management/management.h"

#include "managed_boards.h"
#include "test.h"

namespace gicube::emu {
namespace {

using grpc::StatusCode;
using reference::RawClient;

TEST(Management, ListsEveryBoardWithItsResolvedConfiguration) {
  ManagedBoards managed(2);
  Call call;
  v1::ListBoardsResponse list;
  ASSERT_TRUE(managed.stub->ListBoards(&call, {}, &list).ok());
  ASSERT_EQ(list.boards_size(), 2);
  const v1::BoardInfo& second = list.boards(1);
  EXPECT_EQ(second.board(), 1u);
  EXPECT_EQ(second.bus_endpoint(), "unix:" + managed.boards.path(1));
  EXPECT_THAT(second.product(), HasSubstr("GI-Cube"));
  EXPECT_FALSE(second.version().empty());
  EXPECT_FALSE(second.in_use());
  EXPECT_TRUE(second.config().asic().has_block_voxels());
  EXPECT_EQ(second.config_hash(), config_hash_text(v1::BoardConfig()));
}

TEST(Management, ListsTheScatteringRoutinesOfABoard) {
  ManagedBoards managed;
  const v1::BoardInfo info = managed.info();
  ASSERT_EQ(info.routines_size(), 3);
  EXPECT_EQ(info.routines(1).number(), 1u);
  EXPECT_EQ(info.routines(1).name(), "henyey_greenstein");
  EXPECT_EQ(info.routines(1).cycles(), 200u);
  EXPECT_EQ(info.routines(1).file(), "");
}

TEST(Management, SaysWhenABoardIsInUse) {
  ManagedBoards managed;
  {
    const RawClient client = managed.boards.open();
    EXPECT_TRUE(managed.info().in_use());
  }
  EXPECT_TRUE(serves_afresh(managed.boards));
}

TEST(Management, AnUnknownBoardIsNotFoundByEveryCall) {
  ManagedBoards managed(2);
  v1::BoardInfo info;
  v1::CounterSnapshot snapshot;
  v1::GetInfoRequest get_info;
  v1::ConfigureRequest configure;
  v1::ResetRequest reset;
  v1::GetCountersRequest counters;
  v1::WatchCountersRequest watch;
  get_info.set_board(2), configure.set_board(2), reset.set_board(2), counters.set_board(2), watch.set_board(2);
  Call calls[5];
  EXPECT_EQ(managed.stub->GetInfo(&calls[0], get_info, &info).error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(managed.stub->Configure(&calls[1], configure, &info).error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(managed.stub->Reset(&calls[2], reset, &info).error_code(), StatusCode::NOT_FOUND);
  const grpc::Status status = managed.stub->GetCounters(&calls[3], counters, &snapshot);
  EXPECT_EQ(status.error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(status.error_message(), "board: expected 0 to 1, got 2");
  const auto reader = managed.stub->WatchCounters(&calls[4], watch);
  EXPECT_FALSE(reader->Read(&snapshot));
  EXPECT_EQ(reader->Finish().error_code(), StatusCode::NOT_FOUND);
}

TEST(Management, ConfigureMergesAndRebuildsTheBoard) {
  ManagedBoards managed;
  v1::BoardInfo info;
  ASSERT_TRUE(managed.configure("asic { processors: 8 }", info).ok());
  ASSERT_TRUE(managed.configure("bus { model: agp2x }", info).ok());
  EXPECT_EQ(info.config().asic().processors(), 8u);
  EXPECT_EQ(info.config().bus().model(), v1::agp2x);
  EXPECT_EQ(info.config_hash(), config_hash_text(info.config()));
  RawClient client = managed.boards.open();
  EXPECT_EQ(client.read_register(wire::reg::kProcessors), 8u);
  const auto low = client.read_register(wire::reg::kConfigHashLow),
             high = client.read_register(wire::reg::kConfigHashHigh);
  EXPECT_EQ(high << 32 | low, config_hash(info.config()));
}

TEST(Management, ConfigureNamesEveryFaultAndChangesNothing) {
  ManagedBoards managed;
  const std::string before = managed.info().SerializeAsString();
  v1::BoardInfo info;
  const grpc::Status status =
      managed.configure("asic { processors: 17 speed: 3 }\nfidelity: FIDELITY_UNSPECIFIED\n", info);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), AllOf(HasSubstr("line 1: asic.processors: expected 1 to 16 processors, got 17"),
                                            HasSubstr("line 1: asic.speed: expected one of processors"),
                                            HasSubstr("line 2: fidelity: expected one of functional")));
  EXPECT_EQ(managed.info().SerializeAsString(), before);
}

TEST(Management, TextThatIsNestedDeepIsRefused) {
  ManagedBoards managed;
  std::string text;
  while (text.size() < 240'000) text += "a{";
  v1::BoardInfo info;
  v1::FaultPlanInfo plan;
  for (const grpc::Status& status : {managed.configure(text, info), managed.set_fault_plan(text, plan)}) {
    EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
    EXPECT_THAT(status.error_message(), HasSubstr("line 1: expected a value, got the end of the text"));
  }
}

TEST(Management, ManyFaultsAreToldInAsManyWordsAsAnAnswerHolds) {
  ManagedBoards managed;
  std::string text;
  for (int i = 0; i < 100; ++i) text += std::string(5000, 'x') + ": 1\n";
  v1::BoardInfo info;
  const grpc::Status status = managed.configure(text, info);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(),
              AllOf(HasSubstr("line 1: xxx"), HasSubstr("x...: expected one of fidelity"), EndsWith("\nand more")));
}

TEST(Management, ConfigureIsRefusedWhileASessionOwnsTheBoard) {
  ManagedBoards managed;
  RawClient client = managed.boards.open();
  v1::BoardInfo info;
  const grpc::Status status = managed.configure("asic { processors: 8 }", info);
  EXPECT_EQ(status.error_code(), StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(client.read_register(wire::reg::kProcessors), 4u);
}

TEST(Management, ResetEndsTheOwningSessionEvenInLongWork) {
  ManagedBoards managed;
  RawClient client = managed.boards.open();
  post_long_command(client, 1);
  v1::BoardInfo info;
  ASSERT_TRUE(managed.reset(info).ok());
  EXPECT_FALSE(info.in_use());
  std::optional<reference::RawFrame> last;
  while (auto frame = client.receive()) last = std::move(frame);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->header.error, wire::ErrorCode::kCancelled);
  EXPECT_THAT(last->text(), HasSubstr("reset"));
  EXPECT_TRUE(serves_afresh(managed.boards));
}

TEST(Management, ResetOfAFreeBoardIsDoneAtOnce) {
  ManagedBoards managed;
  v1::BoardInfo info;
  EXPECT_TRUE(managed.reset(info).ok());
  EXPECT_TRUE(serves_afresh(managed.boards));
}

std::uint64_t busy_ps(const v1::CounterSnapshot& snapshot) {
  for (const v1::Counter& counter : snapshot.counters()) {
    if (counter.name() == "bus.down.busy_ps") return counter.value();
  }
  ADD_FAILURE() << "no counter bus.down.busy_ps";
  return 0;
}

TEST(Management, CountersAreThoseOfTheOwningSession) {
  ManagedBoards managed;
  v1::CounterSnapshot before, after;
  Call first, second;
  ASSERT_TRUE(managed.stub->GetCounters(&first, {}, &before).ok());
  RawClient client = managed.boards.open();
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  ASSERT_TRUE(managed.stub->GetCounters(&second, {}, &after).ok());
  EXPECT_EQ(busy_ps(before), 0u);
  EXPECT_GT(busy_ps(after), 0u);
  EXPECT_GT(after.simulated_ps(), before.simulated_ps());
}

TEST(Management, AWatchSeesCountersGrowUntilItIsCancelled) {
  ManagedBoards managed;
  RawClient client = managed.boards.open();
  v1::WatchCountersRequest request;
  request.set_interval_ms(10);
  Call call;
  const auto reader = managed.stub->WatchCounters(&call, request);
  v1::CounterSnapshot snapshot;
  ASSERT_TRUE(reader->Read(&snapshot));
  EXPECT_EQ(busy_ps(snapshot), 0u);
  EXPECT_EQ(client.read_register(wire::reg::kId), wire::kIdValue);
  do {
    ASSERT_TRUE(reader->Read(&snapshot));
  } while (busy_ps(snapshot) == 0);
  call.TryCancel();
  while (reader->Read(&snapshot)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), StatusCode::CANCELLED);
}

TEST(Management, AWatchEndsWithTheProcess) {
  ManagedBoards managed;
  v1::WatchCountersRequest request;
  request.set_interval_ms(60'000);
  Call call;
  const auto reader = managed.stub->WatchCounters(&call, request);
  v1::CounterSnapshot snapshot;
  ASSERT_TRUE(reader->Read(&snapshot));
  managed.management.reset();
  EXPECT_FALSE(reader->Read(&snapshot));
  EXPECT_EQ(reader->Finish().error_code(), StatusCode::UNAVAILABLE);
}

TEST(Management, AWatchIntervalOutOfRangeIsRefused) {
  ManagedBoards managed;
  for (const std::uint32_t interval : {9u, 60'001u}) {
    v1::WatchCountersRequest request;
    request.set_interval_ms(interval);
    Call call;
    const auto reader = managed.stub->WatchCounters(&call, request);
    v1::CounterSnapshot snapshot;
    EXPECT_FALSE(reader->Read(&snapshot));
    const grpc::Status status = reader->Finish();
    EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
    EXPECT_THAT(status.error_message(), HasSubstr("interval_ms: expected 0 or 10 to 60000"));
  }
}

int threads_of_this_process() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

// Each call that waits has a thread.
TEST(Management, AFloodOfCallsGetsSoManyThreadsAndNoMore) {
  constexpr int kCalls = 200, kMaxThreads = 48, kMaxCallsOfConnection = 32;
  ManagedBoards managed;
  BoardSlot& slot = *managed.boards.slots[0];
  ASSERT_EQ(slot.claim({.end_session = [](wire::ErrorCode, const std::string&) {}}), Claim::kGranted);  // does not end
  grpc::CompletionQueue queue;
  const int before = threads_of_this_process();
  struct Waiting {
    Call call;
    v1::BoardInfo info;
    grpc::Status status;
    std::unique_ptr<grpc::ClientAsyncResponseReader<v1::BoardInfo>> reader;
  };
  std::vector<std::unique_ptr<v1::BoardManagement::Stub>> stubs;
  for (int i = 0; i * kMaxCallsOfConnection < kCalls; ++i) {
    grpc::ChannelArguments own;
    own.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    stubs.push_back(v1::BoardManagement::NewStub(grpc::CreateCustomChannel(
        "unix:" + managed.boards.folder.file("management"), grpc::InsecureChannelCredentials(), own)));
  }
  std::vector<std::unique_ptr<Waiting>> waiting;
  for (int i = 0; i < kCalls; ++i) {
    waiting.push_back(std::make_unique<Waiting>());
    Waiting& each = *waiting.back();
    each.reader = stubs[static_cast<std::size_t>(i / kMaxCallsOfConnection)]->AsyncReset(&each.call, {}, &queue);
    each.reader->Finish(&each.info, &each.status, nullptr);
  }
  void* tag = nullptr;
  bool ok = false;
  for (int i = 0; i < kCalls - kMaxThreads; ++i) ASSERT_TRUE(queue.Next(&tag, &ok));  // refused, while the others wait
  EXPECT_LT(threads_of_this_process() - before, 2 * kMaxThreads) << "the client has threads too";
  slot.release();
  for (int i = 0; i < kMaxThreads; ++i) ASSERT_TRUE(queue.Next(&tag, &ok));
  int refused = 0;
  for (const auto& each : waiting) {
    if (each->status.error_code() == StatusCode::RESOURCE_EXHAUSTED) ++refused;
  }
  EXPECT_GE(refused, kCalls - kMaxThreads);
}

TEST(Management, ASeventeenthWatchIsTurnedAway) {
  ManagedBoards managed;
  v1::WatchCountersRequest request;
  v1::CounterSnapshot snapshot;
  std::vector<std::unique_ptr<Call>> calls;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::CounterSnapshot>>> readers;
  for (int i = 0; i < 16; ++i) {
    calls.push_back(std::make_unique<Call>());
    readers.push_back(managed.stub->WatchCounters(calls.back().get(), request));
    ASSERT_TRUE(readers.back()->Read(&snapshot));
  }
  Call call;
  const auto reader = managed.stub->WatchCounters(&call, request);
  EXPECT_FALSE(reader->Read(&snapshot));
  EXPECT_EQ(reader->Finish().error_code(), StatusCode::RESOURCE_EXHAUSTED);
  managed.management.reset();
  for (const auto& each : readers) each->Finish();
}

TEST(Management, OneCallerAtATimeDebugsABoardWhichAnswersAllOthers) {
  ManagedBoards managed;
  const auto say = [](auto& stream, const std::string& line) {
    v1::DebugRequest request;
    request.set_line(line);
    v1::DebugAnswer answer;
    stream.Write(request);
    stream.Read(&answer);
    return answer;
  };
  for (int round = 0; round < 2; ++round) {  // the second is let in when the first has left
    Call call, other_call;
    const auto debugger = managed.stub->Debug(&call), other = managed.stub->Debug(&other_call);
    EXPECT_EQ(say(*debugger, "where").text(), "the board is not paused\n");
    say(*other, "where");
    EXPECT_EQ(other->Finish().error_code(), StatusCode::FAILED_PRECONDITION);
    EXPECT_FALSE(say(*debugger, "break command").is_fault());
    EXPECT_TRUE(say(*debugger, "break nothing").is_fault());
    const v1::DebugAnswer saved = say(*debugger, "checkpoint round" + std::to_string(round));
    EXPECT_THAT(saved.text(), HasSubstr("ps is in " + managed.traces() + "/round" + std::to_string(round)));
    EXPECT_TRUE(say(*debugger, "checkpoint ../round").is_fault());
    EXPECT_EQ(managed.info().board(), 0u);
    debugger->WritesDone();
    EXPECT_TRUE(debugger->Finish().ok());
  }
  Call call;
  const auto nobody = managed.stub->Debug(&call);
  v1::DebugRequest request;
  request.set_board(7);
  nobody->Write(request);
  EXPECT_EQ(nobody->Finish().error_code(), StatusCode::NOT_FOUND);
}

TEST(Management, AFaultPlanIsSetShownAndTakenBack) {
  ManagedBoards managed(2);
  const std::string plan = "fault { direction: down message: 1000000 kind: drop }";
  v1::FaultPlanInfo info;
  ASSERT_TRUE(managed.set_fault_plan(plan, info).ok());
  EXPECT_EQ(info.plan_text(), plan);
  for (const std::uint32_t board : {0u, 1u}) {
    Call call;
    v1::GetFaultPlanRequest request;
    request.set_board(board);
    ASSERT_TRUE(managed.stub->GetFaultPlan(&call, request, &info).ok());
    EXPECT_EQ(info.plan_text(), board == 0 ? plan : "");
    EXPECT_EQ(info.faults(), 0u);
  }
  ASSERT_TRUE(managed.set_fault_plan("", info).ok());
  EXPECT_EQ(info.plan_text(), "");
}

TEST(Management, AFaultyFaultPlanNamesEveryFaultAndChangesNothing) {
  ManagedBoards managed;
  v1::FaultPlanInfo info;
  const grpc::Status status = managed.set_fault_plan("fault { kind: hiccup }\nfoult {}", info);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(),
              AllOf(HasSubstr("line 1: fault[0].kind: expected one of drop"), HasSubstr("line 2: foult: expected")));
  EXPECT_EQ(managed.fault_log().faults_size(), 0);
}

TEST(Management, AnUnknownBoardHasNoFaultPlan) {
  ManagedBoards managed;
  v1::SetFaultPlanRequest set;
  v1::GetFaultPlanRequest get;
  v1::GetFaultLogRequest get_log;
  set.set_board(1), get.set_board(1), get_log.set_board(1);
  v1::FaultPlanInfo info;
  v1::FaultLog log;
  Call calls[3];
  EXPECT_EQ(managed.stub->SetFaultPlan(&calls[0], set, &info).error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(managed.stub->GetFaultPlan(&calls[1], get, &info).error_code(), StatusCode::NOT_FOUND);
  EXPECT_EQ(managed.stub->GetFaultLog(&calls[2], get_log, &log).error_code(), StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace gicube::emu
