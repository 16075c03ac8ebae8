#include "management.h"

#include <fmt/format.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "describe.h"
#include "gicube/v1/management.grpc.pb.h"
#include "server/bus/back_off.h"
#include "server/bus/session.h"
#include "words/finally.h"

namespace gicube::emu {
namespace {

using grpc::ServerContext;
using grpc::Status;
using grpc::StatusCode;

constexpr int kMaxWatchers = 16;  // chosen: each holds a thread
constexpr std::uint32_t kMinIntervalMs = 10, kMaxIntervalMs = 60'000, kDefaultIntervalMs = 1000;
constexpr std::chrono::milliseconds kCancelCheck{50};     // chosen: how late a cancelled watch is noticed
constexpr std::chrono::milliseconds kShutdownGrace{200};  // chosen: with the last words to clients less than kMaxEnding
constexpr int kMaxMessageBytes = 2 << 20;                 // chosen: twice what a configuration text may have
constexpr int kMaxThreads = 48;                           // chosen: three times the watches; each call has one
constexpr int kMaxCallsOfConnection = 32;                 // chosen: twice the watches; more wait for these
constexpr std::size_t kMaxMemoryBytes = std::size_t{64} << 20;  // chosen: a configuration for each of 32 calls

// Asks every call for a token, those of health and reflection too. Who has a wrong one waits for the refusal, each time longer, so that tokens are guessed slowly; only a few do, since each of them holds a thread.
class TokenCheck final : public grpc::AuthMetadataProcessor {
 public:
  TokenCheck(std::vector<AccessToken> tokens, Audit* audit) : tokens_(std::move(tokens)), audit_(audit) {}

  bool IsBlocking() const override { return true; }

  // The token stays in the call's metadata: what it lets its holder do is asked for each call by right_in().
  Status Process(const InputMetadata& metadata, grpc::AuthContext*, OutputMetadata*, OutputMetadata*) override {
    if (right_in(metadata)) return Status::OK;
    hold_back(metadata.find(kHeader) != metadata.end());
    return {StatusCode::UNAUTHENTICATED, "expected the metadata \"authorization: Bearer TOKEN\""};
  }

  std::optional<Right> right_in(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata) const {
    const auto found = metadata.find(kHeader);
    if (found == metadata.end()) return std::nullopt;
    return right_of(tokens_, bearer_token({found->second.data(), found->second.size()}));
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    stopped_.notify_all();
  }

 private:
  using Clock = BackOff::Clock;
  static constexpr const char* kHeader = "authorization";

  void hold_back(bool has_one) {
    constexpr int kMaxHeld = 4;  // chosen
    if (audit_ != nullptr) {
      audit_->note(AuditEvent::kUnknown, "management caller", has_one ? "its token is wrong" : "it has no token");
    }
    std::unique_lock lock(mutex_);
    if (held_ >= kMaxHeld) return;
    ++held_;
    wrong_.happened(Clock::now());
    stopped_.wait_for(lock, wrong_.left(Clock::now()), [this] { return stopping_; });
    --held_;
  }

  const std::vector<AccessToken> tokens_;
  Audit* const audit_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  BackOff wrong_{BusOptions().token_pause, BusOptions().longest_token_pause};
  int held_ = 0;
  bool stopping_ = false;
};

class Service final : public v1::BoardManagement::Service {
 public:
  using DebugStream = grpc::ServerReaderWriter<v1::DebugAnswer, v1::DebugRequest>;

  // `tokens`: null if nobody is asked for one.
  Service(std::vector<BoardSlot*> boards, const ManagementOptions& options, std::shared_ptr<const TokenCheck> tokens)
      : boards_(std::move(boards)),
        trace_folder_(options.trace_folder),
        audit_(options.audit),
        tokens_(std::move(tokens)) {}

  Status ListBoards(ServerContext*, const v1::ListBoardsRequest*, v1::ListBoardsResponse* response) override {
    for (const BoardSlot* slot : boards_) describe(*slot, *response->add_boards());
    return Status::OK;
  }

  Status GetInfo(ServerContext*, const v1::GetInfoRequest* in, v1::BoardInfo* out) override { return show(in, out); }

  Status Configure(ServerContext* context, const v1::ConfigureRequest* request, v1::BoardInfo* info) override {
    if (Status refused = lacks(*context, Right::kControl); !refused.ok()) return refused;
    return on_board(*request, [&](BoardSlot& slot) {
      std::string reason;
      const auto result = slot.configure(request->config_text(), reason, given_up(*context));
      const bool is_done = result == BoardSlot::Configured::kDone;
      return noted(AuditEvent::kConfigured, *context, slot,
                   is_done ? shown(slot, *info) : refusal(result, slot, reason));
    });
  }

  Status Reset(ServerContext* context, const v1::ResetRequest* request, v1::BoardInfo* info) override {
    if (Status refused = lacks(*context, Right::kControl); !refused.ok()) return refused;
    return on_board(*request, [&](BoardSlot& slot) -> Status {
      std::string reason;
      const auto result = slot.power_reset(reason, given_up(*context));
      Status status{StatusCode::DEADLINE_EXCEEDED, "the session that owns the board does not end"};
      if (result == BoardSlot::Configured::kDone) {
        status = shown(slot, *info);
      } else if (result != BoardSlot::Configured::kInUse) {
        status = refusal(result, slot, reason);
      }
      return noted(AuditEvent::kReset, *context, slot, status);
    });
  }

  Status GetCounters(ServerContext*, const v1::GetCountersRequest* in, v1::CounterSnapshot* out) override {
    return show(in, out);
  }

  Status SetTrace(ServerContext* context, const v1::SetTraceRequest* request, v1::TraceInfo* info) override {
    if (Status refused = lacks(*context, Right::kControl); !refused.ok()) return refused;
    return on_board(*request, [&](BoardSlot& slot) -> Status {
      std::string reason, path;
      try {
        if (!request->file().empty()) path = trace_path(trace_folder_, request->file());
      } catch (const std::invalid_argument& error) {
        return noted(AuditEvent::kTraced, *context, slot, {StatusCode::INVALID_ARGUMENT, error.what()});
      }
      const auto result = slot.set_trace_file(path, reason, given_up(*context));
      const bool is_done = result == BoardSlot::Configured::kDone;
      return noted(AuditEvent::kTraced, *context, slot, is_done ? shown(slot, *info) : refusal(result, slot, reason),
                   path.empty() ? "no trace" : path);
    });
  }

  Status SaveCheckpoint(ServerContext* context, const v1::SaveCheckpointRequest* request,
                        v1::CheckpointInfo* info) override {
    if (Status refused = lacks(*context, Right::kControl); !refused.ok()) return refused;
    return on_board(*request, [&](BoardSlot& slot) { return save(*context, slot, request->file(), *info); });
  }

  Status GetTrace(ServerContext*, const v1::GetTraceRequest* in, v1::TraceInfo* out) override { return show(in, out); }

  Status WatchCounters(ServerContext* context, const v1::WatchCountersRequest* request,
                       grpc::ServerWriter<v1::CounterSnapshot>* writer) override {
    return on_board(*request, [&](BoardSlot& slot) { return watch(*context, *request, slot, *writer); });
  }

  Status SetFaultPlan(ServerContext* context, const v1::SetFaultPlanRequest* request,
                      v1::FaultPlanInfo* info) override {
    if (Status refused = lacks(*context, Right::kControl); !refused.ok()) return refused;
    return on_board(*request, [&](BoardSlot& slot) -> Status {
      const std::vector<Diagnostic> found = slot.faults().set_plan(request->plan_text());
      const Status refused{StatusCode::INVALID_ARGUMENT, in_short(to_string(found))};
      return noted(AuditEvent::kFaultsSet, *context, slot, found.empty() ? shown(slot, *info) : refused);
    });
  }

  Status GetFaultPlan(ServerContext*, const v1::GetFaultPlanRequest* in, v1::FaultPlanInfo* out) override {
    return show(in, out);
  }

  Status GetFaultLog(ServerContext* context, const v1::GetFaultLogRequest* request, v1::FaultLog* log) override {
    if (Status refused = lacks(*context, request->clear() ? Right::kControl : Right::kRead); !refused.ok())
      return refused;
    return on_board(*request, [&](BoardSlot& slot) {
      log->set_board(slot.index());
      FaultPoint::Log logged = slot.faults().log(request->clear());
      log->set_left_out(logged.left_out);
      for (v1::PlannedFault& fault : logged.faults) *log->add_faults() = std::move(fault);
      return Status::OK;
    });
  }

  Status Debug(ServerContext* context, DebugStream* stream) override {
    if (Status refused = lacks(*context, Right::kControl); !refused.ok()) return refused;
    v1::DebugRequest first;
    if (!stream->Read(&first)) return Status::OK;
    return on_board(first, [&](BoardSlot& slot) { return debug(*context, first, slot, *stream); });
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    stopped_.notify_all();
  }

 private:
  Status save(const ServerContext& context, BoardSlot& slot, const std::string& file, v1::CheckpointInfo& info) {
    std::string reason, path;
    try {
      path = trace_path(trace_folder_, file);
    } catch (const std::invalid_argument& error) {
      return noted(AuditEvent::kSaved, context, slot, {StatusCode::INVALID_ARGUMENT, error.what()});
    }
    BoardSlot::Saved saved;
    const auto result = slot.save(path, saved, reason, given_up(context));
    if (result != BoardSlot::Configured::kDone) {
      return noted(AuditEvent::kSaved, context, slot, refusal(result, slot, reason), path);
    }
    info.set_board(slot.index());
    info.set_file(path);
    info.set_simulated_ps(saved.simulated_ps);
    info.set_bytes(saved.bytes);
    return noted(AuditEvent::kSaved, context, slot, Status::OK, path);
  }

  // The line "checkpoint FILE" of a debugger.
  Debugger::Answer save_in_debug(const ServerContext& context, BoardSlot& slot, const std::string& file) {
    v1::CheckpointInfo info;
    const Status status = save(context, slot, file, info);
    const bool stands = slot.debugger().stands();
    if (!status.ok()) return {"checkpoint: " + status.error_message() + '\n', true, stands};
    return {fmt::format("board {} at {} ps is in {}, {} bytes\n", info.board(), info.simulated_ps(), info.file(),
                        info.bytes()),
            false, stands};
  }

  Status debug(const ServerContext& context, v1::DebugRequest& request, BoardSlot& slot, DebugStream& stream) {
    Debugger& debugger = slot.debugger();
    if (!debugger.attach()) {
      return noted(AuditEvent::kDebugged, context, slot,
                   {StatusCode::FAILED_PRECONDITION, fmt::format("another caller debugs board {}", slot.index())});
    }
    const Finally detached{[&debugger] { debugger.detach(); }};
    noted(AuditEvent::kDebugged, context, slot, Status::OK, "attached");
    do {
      constexpr std::string_view kCheckpoint = "checkpoint ";
      const Debugger::Answer said = request.line().starts_with(kCheckpoint)
                                        ? save_in_debug(context, slot, request.line().substr(kCheckpoint.size()))
                                        : debugger.carry_out(request.line(), given_up(context));
      // What changes values on the board is in the log.
      if (!said.is_fault && request.line().starts_with("set ")) {
        noted(AuditEvent::kDebugged, context, slot, Status::OK, request.line().substr(0, 80));
      }
      v1::DebugAnswer answer;
      answer.set_text(said.text);
      answer.set_is_fault(said.is_fault);
      answer.set_stands(said.stands);
      if (!stream.Write(answer)) break;
    } while (stream.Read(&request));
    return Status::OK;
  }

  void note(AuditEvent event, const ServerContext& context, const std::string& what) const {
    if (audit_ != nullptr) audit_->note(event, "management caller " + context.peer(), what);
  }
  // What a call of this kind has come to.
  Status noted(AuditEvent event, const ServerContext& context, const BoardSlot& slot, const Status& status,
               const std::string& what = "") const {
    const std::string result = status.ok() ? "done" : "refused: " + status.error_message();
    note(event, context, fmt::format("board {}: {}{}{}", slot.index(), what, what.empty() ? "" : ": ", result));
    return status;
  }

  // Why a caller may not do what needs this right.
  Status lacks(const ServerContext& context, Right needed) const {
    if (!tokens_) return Status::OK;
    const std::optional<Right> right = tokens_->right_in(context.client_metadata());
    if (right && *right >= needed) return Status::OK;
    note(AuditEvent::kForbidden, context, fmt::format("asked for what needs the right to {}", name_of(needed)));
    return {StatusCode::PERMISSION_DENIED,
            fmt::format("expected a token with the right to {}, got one with the right to {}", name_of(needed),
                        right ? name_of(*right) : "nothing")};
  }

  // Has `work` do what a request asks of the board that it names.
  template <typename Request, typename Work>
  Status on_board(const Request& request, const Work& work) const {
    if (request.board() < boards_.size()) return work(*boards_[request.board()]);
    return {StatusCode::NOT_FOUND, fmt::format("board: expected 0 to {}, got {}", boards_.size() - 1, request.board())};
  }

  // What one may see of the board that a request names.
  template <typename Request, typename Message>
  Status show(const Request* request, Message* out) const {
    return on_board(*request, [&](BoardSlot& slot) { return shown(slot, *out); });
  }

  static Status refusal(BoardSlot::Configured result, const BoardSlot& slot, const std::string& reason) {
    switch (result) {
      case BoardSlot::Configured::kFaulty: return {StatusCode::INVALID_ARGUMENT, in_short(reason)};
      case BoardSlot::Configured::kFailed: return {StatusCode::RESOURCE_EXHAUSTED, reason};
      case BoardSlot::Configured::kCancelled:
        return {StatusCode::CANCELLED, "the caller has given up, or the process ends"};
      default: return {StatusCode::FAILED_PRECONDITION, fmt::format("board {} has an owner", slot.index())};
    }
  }

  // gRPC refuses metadata of more than 8 KiB, in which a status travels percent-encoded.
  static std::string in_short(std::string text) {
    constexpr std::size_t kMaxBytes = 4096;  // chosen
    if (text.size() <= kMaxBytes) return text;
    text.resize(text.rfind('\n', kMaxBytes) == std::string::npos ? kMaxBytes : text.rfind('\n', kMaxBytes));
    return text + "\nand more";
  }

  Cancelled given_up(const ServerContext& context) {
    return [this, &context] {
      const std::lock_guard lock(mutex_);
      return stopping_ || context.IsCancelled();
    };
  }

  Status watch(const ServerContext& context, const v1::WatchCountersRequest& request, const BoardSlot& slot,
               grpc::ServerWriter<v1::CounterSnapshot>& writer) {
    const std::uint32_t interval_ms = request.interval_ms() == 0 ? kDefaultIntervalMs : request.interval_ms();
    if (interval_ms < kMinIntervalMs || interval_ms > kMaxIntervalMs) {
      return {StatusCode::INVALID_ARGUMENT,
              fmt::format("interval_ms: expected 0 or {} to {}, got {}", kMinIntervalMs, kMaxIntervalMs, interval_ms)};
    }
    const int number = ++watchers_;
    const Finally left{[this] { --watchers_; }};
    if (number > kMaxWatchers) {
      return {StatusCode::RESOURCE_EXHAUSTED, fmt::format("expected at most {} watches at a time", kMaxWatchers)};
    }
    auto next = std::chrono::steady_clock::now();
    do {
      v1::CounterSnapshot snapshot;
      describe(slot, snapshot);
      if (!writer.Write(snapshot)) return Status::OK;
      next += std::chrono::milliseconds(interval_ms);
    } while (sleep_until(next, context));
    if (context.IsCancelled()) return Status::CANCELLED;
    return {StatusCode::UNAVAILABLE, "the board process ends"};
  }

  // What one may see of the board: describe.h has it all.
  template <typename Slot, typename Message>
  static Status shown(Slot& slot, Message& out) {
    describe(slot, out);
    return Status::OK;
  }

  // False if the call was cancelled or the service stops before that.
  bool sleep_until(std::chrono::steady_clock::time_point time, const ServerContext& context) {
    std::unique_lock lock(mutex_);
    while (!stopping_ && !context.IsCancelled()) {
      const auto now = std::chrono::steady_clock::now();
      if (now >= time) return true;
      stopped_.wait_until(lock, std::min(time, now + kCancelCheck));
    }
    return false;
  }

  const std::vector<BoardSlot*> boards_;
  const std::string trace_folder_;
  Audit* const audit_;
  const std::shared_ptr<const TokenCheck> tokens_;
  std::atomic<int> watchers_{0};
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stopping_ = false;
};

std::string read_pem(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{}: can't be read", path));
  return {std::istreambuf_iterator<char>(file), {}};
}

// `check`: of callers over TCP.
std::shared_ptr<grpc::ServerCredentials> credentials(const ManagementOptions& options,
                                                     const std::shared_ptr<TokenCheck>& check) {
  if (options.endpoint.kind == EndpointKind::kUnix) return grpc::InsecureServerCredentials();
  std::shared_ptr<grpc::ServerCredentials> asking;
  if (options.certificate_file.empty()) {
    asking = grpc::experimental::LocalServerCredentials(LOCAL_TCP);
  } else {
    grpc::SslServerCredentialsOptions tls;
    tls.pem_key_cert_pairs.push_back({read_pem(options.key_file), read_pem(options.certificate_file)});
    asking = grpc::SslServerCredentials(tls);
  }
  asking->SetAuthMetadataProcessor(check);
  return asking;
}

std::vector<AccessToken> all_tokens(const ManagementOptions& options) {
  std::vector<AccessToken> tokens = options.tokens;
  if (!options.token_file.empty()) {
    for (AccessToken& each : read_tokens(options.token_file)) tokens.push_back(std::move(each));
  }
  return tokens;
}

}  // namespace

std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  return authorization.starts_with(kScheme) ? authorization.substr(kScheme.size()) : std::string_view();
}

std::vector<Diagnostic> check(const ManagementOptions& options) {
  const std::string endpoint = to_string(options.endpoint);
  if (options.endpoint.kind == EndpointKind::kFd) return {{"--management", "unix:PATH or tcp:HOST:PORT", endpoint}};
  if (is_local(options.endpoint)) return {};
  std::string missing;
  for (const auto& [flag, file] :
       {std::pair("--tls-cert", &options.certificate_file), std::pair("--tls-key", &options.key_file),
        std::pair("--token-file", &options.token_file)}) {
    if (file->empty()) missing += (missing.empty() ? "" : ", ") + std::string(flag);
  }
  if (missing.empty()) return {};
  return {{"--management", fmt::format("a loopback address or a unix socket, or TLS and a token by {}", missing),
           endpoint + ", which other machines can reach"}};
}

std::string trace_path(const std::string& folder, const std::string& file) {
  if (folder.empty()) {
    throw std::invalid_argument("file: expected none, the board process has no --trace-dir; got " + file);
  }
  const std::filesystem::path path(file);
  const std::string name = path.filename().string();
  const bool is_there = !path.has_parent_path() || path.parent_path() == folder;
  if (!is_there || name.empty() || name.starts_with('.')) {
    throw std::invalid_argument(fmt::format("file: expected the name of a new file in {}, got {}", folder, file));
  }
  return (std::filesystem::path(folder) / name).string();
}

struct Management::Parts {
  Endpoint endpoint;
  std::shared_ptr<TokenCheck> tokens;  // null at a Unix socket, whose file is its owner's alone
  Service service;
  std::unique_ptr<grpc::Server> server;

  Parts(std::vector<BoardSlot*> boards, const ManagementOptions& options)
      : endpoint(options.endpoint),
        tokens(endpoint.kind == EndpointKind::kTcp ? std::make_shared<TokenCheck>(all_tokens(options), options.audit)
                                                   : nullptr),
        service(std::move(boards), options, tokens) {}
};

Management::Management(const ManagementOptions& options, std::vector<BoardSlot*> boards)
    : parts_(std::make_unique<Parts>(std::move(boards), options)) {
  const std::vector<Diagnostic> found = check(options);
  if (!found.empty()) throw std::runtime_error(to_string(found));
  const bool is_unix = options.endpoint.kind == EndpointKind::kUnix;
  if (is_unix) remove_stale_socket(options.endpoint.path);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  // Without that a second process would silently share the port.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  // Calls beyond that end with RESOURCE_EXHAUSTED.
  grpc::ResourceQuota quota("management");
  quota.SetMaxThreads(kMaxThreads);
  quota.Resize(kMaxMemoryBytes);
  builder.SetResourceQuota(quota);
  builder.SetSyncServerOption(grpc::ServerBuilder::NUM_CQS, 1);  // else one a core, with threads of its own
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxCallsOfConnection);
  int port = 0;
  const std::string text = to_string(options.endpoint);
  builder.AddListeningPort(is_unix ? text : text.substr(std::string("tcp:").size()),
                           credentials(options, parts_->tokens), &port);
  builder.RegisterService(&parts_->service);
  parts_->server = builder.BuildAndStart();
  if (!parts_->server)
    throw std::runtime_error(fmt::format("{}: can't listen there, or the certificate is no good", text));
  if (!is_unix) parts_->endpoint.port = static_cast<std::uint16_t>(port);
  grpc::HealthCheckServiceInterface* health = parts_->server->GetHealthCheckService();
  health->SetServingStatus(v1::BoardManagement::service_full_name(), true);
}

Management::~Management() {
  if (!parts_->server) return;
  parts_->server->GetHealthCheckService()->SetServingStatus(false);
  parts_->service.stop();
  if (parts_->tokens) parts_->tokens->stop();
  parts_->server->Shutdown(std::chrono::system_clock::now() + kShutdownGrace);
  parts_->server->Wait();
}

const Endpoint& Management::endpoint() const { return parts_->endpoint; }

}  // namespace gicube::emu
