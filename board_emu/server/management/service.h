// The calls of the management plane. Included only by management.cpp, because gRPC's headers are heavy.
#pragma once

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "describe.h"
#include "gicube/v1/management.grpc.pb.h"
#include "management.h"
#include "token_check.h"
#include "words/scope_exit.h"

namespace gicube::emu {

using grpc::ServerContext;
using grpc::Status;
using grpc::StatusCode;

inline constexpr int kMaxWatchers = 16;  // chosen: each occupies a thread
inline constexpr std::uint32_t kMinIntervalMs = 10, kMaxIntervalMs = 60'000, kDefaultIntervalMs = 1000;
inline constexpr std::chrono::milliseconds kCancelCheck{50};  // chosen: latency for detecting a cancelled watch

class Service final : public v1::BoardManagement::Service {
 public:
  using DebugStream = grpc::ServerReaderWriter<v1::DebugAnswer, v1::DebugRequest>;

  // `tokens`: null if callers do not need one.
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
    return control(*context, AuditEvent::kConfigured, *request, *info, [&](BoardSlot& slot, Report& report) {
      return slot.configure(request->config_text(), report.reason, given_up(*context));
    });
  }

  Status Reset(ServerContext* context, const v1::ResetRequest* request, v1::BoardInfo* info) override {
    return control(*context, AuditEvent::kReset, *request, *info, [&](BoardSlot& slot, Report& report) {
      report.in_use = {StatusCode::DEADLINE_EXCEEDED, "the session that owns the board does not end"};
      return slot.power_reset(report.reason, given_up(*context));
    });
  }

  Status GetCounters(ServerContext*, const v1::GetCountersRequest* in, v1::CounterSnapshot* out) override {
    return show(in, out);
  }

  Status SetTrace(ServerContext* context, const v1::SetTraceRequest* request, v1::TraceInfo* info) override {
    return control(*context, AuditEvent::kTraced, *request, *info, [&](BoardSlot& slot, Report& report) {
      const std::string path = request->file().empty() ? "" : trace_path(trace_folder_, request->file());
      report.what = path.empty() ? "no trace" : path;
      return slot.set_trace_file(path, report.reason, given_up(*context));
    });
  }

  Status SaveCheckpoint(ServerContext* context, const v1::SaveCheckpointRequest* request,
                        v1::CheckpointInfo* info) override {
    return save(*context, *request, *info);
  }

  Status GetTrace(ServerContext*, const v1::GetTraceRequest* in, v1::TraceInfo* out) override { return show(in, out); }

  Status WatchCounters(ServerContext* context, const v1::WatchCountersRequest* request,
                       grpc::ServerWriter<v1::CounterSnapshot>* writer) override {
    return on_board(*request, [&](BoardSlot& slot) { return watch(*context, *request, slot, *writer); });
  }

  Status SetFaultPlan(ServerContext* context, const v1::SetFaultPlanRequest* request,
                      v1::FaultPlanInfo* info) override {
    return control(*context, AuditEvent::kFaultsSet, *request, *info, [&](BoardSlot& slot, Report& report) {
      report.reason = to_string(slot.faults().set_plan(request->plan_text()));
      return report.reason.empty() ? Result::kDone : Result::kFaulty;
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
  using Result = BoardSlot::Configured;

  // Describes a call that changes a board.
  struct Report {
    std::string reason;  // of kFaulty and kFailed
    std::string what;    // for the audit log
    Status in_use{};     // for kInUse; OK: the usual status
  };

  // Carries out `work` for a caller with the right to control the board, fills `out` if describe.h can, and logs the
  // result.
  template <typename Request, typename Message, typename Work>
  Status control(const ServerContext& context, AuditEvent event, const Request& request, Message& out,
                 const Work& work) {
    if (Status refused = lacks(context, Right::kControl); !refused.ok()) return refused;
    return on_board(request, [&](BoardSlot& slot) {
      Report report;
      Result result = Result::kFaulty;
      try {
        result = work(slot, report);
      } catch (const std::invalid_argument& error) {
        report.reason = error.what();
      }
      if constexpr (requires { describe(slot, out); }) {
        if (result == Result::kDone) describe(slot, out);
      }
      const bool has_own = result == Result::kInUse && !report.in_use.ok();
      return noted(event, context, slot, has_own ? report.in_use : status_of(result, slot, report.reason), report.what);
    });
  }

  Status save(const ServerContext& context, const v1::SaveCheckpointRequest& request, v1::CheckpointInfo& info) {
    return control(context, AuditEvent::kSaved, request, info, [&](BoardSlot& slot, Report& report) {
      report.what = trace_path(trace_folder_, request.file());
      BoardSlot::Saved saved;
      const Result result = slot.save(report.what, saved, report.reason, given_up(context));
      info.set_board(slot.index());
      info.set_file(report.what);
      info.set_simulated_ps(saved.simulated_ps);
      info.set_bytes(saved.bytes);
      return result;
    });
  }

  // Executes the line "checkpoint FILE" of a debugger.
  Debugger::Answer save_in_debug(const ServerContext& context, BoardSlot& slot, const std::string& file) {
    v1::SaveCheckpointRequest request;
    request.set_board(slot.index());
    request.set_file(file);
    v1::CheckpointInfo info;
    const Status status = save(context, request, info);
    const bool is_paused = slot.debugger().is_paused();
    if (!status.ok()) return {"checkpoint: " + status.error_message() + '\n', true, is_paused};
    return {fmt::format("board {} at {} ps is in {}, {} bytes\n", info.board(), info.simulated_ps(), info.file(),
                        info.bytes()),
            false, is_paused};
  }

  Status debug(const ServerContext& context, v1::DebugRequest& request, BoardSlot& slot, DebugStream& stream) {
    Debugger& debugger = slot.debugger();
    if (!debugger.attach()) {
      return noted(AuditEvent::kDebugged, context, slot,
                   {StatusCode::FAILED_PRECONDITION, fmt::format("another caller debugs board {}", slot.index())}, "");
    }
    const ScopeExit detached{[&debugger] { debugger.detach(); }};
    noted(AuditEvent::kDebugged, context, slot, Status::OK, "attached");
    do {
      constexpr std::string_view kCheckpoint = "checkpoint ";
      const Debugger::Answer reply = request.line().starts_with(kCheckpoint)
                                         ? save_in_debug(context, slot, request.line().substr(kCheckpoint.size()))
                                         : debugger.carry_out(request.line(), given_up(context));
      // Commands that change values on the board are logged.
      if (!reply.is_fault && request.line().starts_with("set ")) {
        noted(AuditEvent::kDebugged, context, slot, Status::OK, request.line().substr(0, 80));
      }
      v1::DebugAnswer answer;
      answer.set_text(reply.text);
      answer.set_is_fault(reply.is_fault);
      answer.set_stands(reply.is_paused);
      if (!stream.Write(answer)) break;
    } while (stream.Read(&request));
    return Status::OK;
  }

  void note(AuditEvent event, const ServerContext& context, const std::string& what) const {
    if (audit_ != nullptr) audit_->note(event, "management caller " + context.peer(), what);
  }
  // Logs the result of a call.
  Status noted(AuditEvent event, const ServerContext& context, const BoardSlot& slot, const Status& status,
               const std::string& what) const {
    const std::string result = status.ok() ? "done" : "refused: " + status.error_message();
    note(event, context, fmt::format("board {}: {}{}{}", slot.index(), what, what.empty() ? "" : ": ", result));
    return status;
  }

  // Returns an error if the caller lacks this right.
  Status lacks(const ServerContext& context, Right needed) const {
    if (!tokens_) return Status::OK;
    const std::optional<Right> right = tokens_->right_in(context.client_metadata());
    if (right && *right >= needed) return Status::OK;
    note(AuditEvent::kForbidden, context, fmt::format("made a call that needs the right to {}", name_of(needed)));
    return {StatusCode::PERMISSION_DENIED,
            fmt::format("expected a token with the right to {}, got one with the right to {}", name_of(needed),
                        right ? name_of(*right) : "nothing")};
  }

  // Calls `work` with the board that the request names.
  template <typename Request, typename Work>
  Status on_board(const Request& request, const Work& work) const {
    if (request.board() < boards_.size()) return work(*boards_[request.board()]);
    return {StatusCode::NOT_FOUND, fmt::format("board: expected 0 to {}, got {}", boards_.size() - 1, request.board())};
  }

  // Fills a message with the public state of the board that the request names.
  template <typename Request, typename Message>
  Status show(const Request* request, Message* out) const {
    return on_board(*request, [&](BoardSlot& slot) {
      describe(slot, *out);
      return Status::OK;
    });
  }

  static Status status_of(Result result, const BoardSlot& slot, const std::string& reason) {
    switch (result) {
      case Result::kDone: return Status::OK;
      case Result::kFaulty: return {StatusCode::INVALID_ARGUMENT, in_short(reason)};
      case Result::kFailed: return {StatusCode::RESOURCE_EXHAUSTED, reason};
      case Result::kCancelled: return {StatusCode::CANCELLED, "the call was cancelled, or the board process ends"};
      case Result::kInUse: break;
    }
    return {StatusCode::FAILED_PRECONDITION, fmt::format("board {} has an owner", slot.index())};
  }

  // gRPC refuses metadata above 8 KiB, in which a status is sent percent-encoded.
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
    const ScopeExit left{[this] { --watchers_; }};
    if (number > kMaxWatchers) {
      return {StatusCode::RESOURCE_EXHAUSTED,
              fmt::format("expected at most {} watches at a time, got one more", kMaxWatchers)};
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

  // Returns false if the call is cancelled or the service stops before that time.
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

}  // namespace gicube::emu
