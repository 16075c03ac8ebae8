#include "management.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "describe.h"
#include "gicube/v1/management.grpc.pb.h"
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

class Service final : public v1::BoardManagement::Service {
 public:
  Service(std::vector<BoardSlot*> boards, std::string trace_folder)
      : boards_(std::move(boards)), trace_folder_(std::move(trace_folder)) {}

  Status ListBoards(ServerContext*, const v1::ListBoardsRequest*, v1::ListBoardsResponse* response) override {
    for (const BoardSlot* slot : boards_) describe(*slot, *response->add_boards());
    return Status::OK;
  }

  Status GetInfo(ServerContext*, const v1::GetInfoRequest* in, v1::BoardInfo* out) override { return show(in, out); }

  Status Configure(ServerContext* context, const v1::ConfigureRequest* request, v1::BoardInfo* info) override {
    return on_board(*request, [&](BoardSlot& slot) {
      std::string reason;
      const auto result = slot.configure(request->config_text(), reason, given_up(*context));
      return result == BoardSlot::Configured::kDone ? shown(slot, *info) : refusal(result, slot, reason);
    });
  }

  Status Reset(ServerContext* context, const v1::ResetRequest* request, v1::BoardInfo* info) override {
    return on_board(*request, [&](BoardSlot& slot) -> Status {
      std::string reason;
      const auto result = slot.power_reset(reason, given_up(*context));
      if (result == BoardSlot::Configured::kDone) return shown(slot, *info);
      if (result != BoardSlot::Configured::kInUse) return refusal(result, slot, reason);
      return {StatusCode::DEADLINE_EXCEEDED, "the session that owns the board does not end"};
    });
  }

  Status GetCounters(ServerContext*, const v1::GetCountersRequest* in, v1::CounterSnapshot* out) override {
    return show(in, out);
  }

  Status SetTrace(ServerContext* context, const v1::SetTraceRequest* request, v1::TraceInfo* info) override {
    return on_board(*request, [&](BoardSlot& slot) -> Status {
      std::string reason, path;
      try {
        if (!request->file().empty()) path = trace_path(trace_folder_, request->file());
      } catch (const std::invalid_argument& error) {
        return {StatusCode::INVALID_ARGUMENT, error.what()};
      }
      const auto result = slot.set_trace_file(path, reason, given_up(*context));
      return result == BoardSlot::Configured::kDone ? shown(slot, *info) : refusal(result, slot, reason);
    });
  }

  Status GetTrace(ServerContext*, const v1::GetTraceRequest* in, v1::TraceInfo* out) override { return show(in, out); }

  Status WatchCounters(ServerContext* context, const v1::WatchCountersRequest* request,
                       grpc::ServerWriter<v1::CounterSnapshot>* writer) override {
    return on_board(*request, [&](BoardSlot& slot) { return watch(*context, *request, slot, *writer); });
  }

  Status SetFaultPlan(ServerContext*, const v1::SetFaultPlanRequest* request, v1::FaultPlanInfo* info) override {
    return on_board(*request, [&](BoardSlot& slot) -> Status {
      const std::vector<Diagnostic> found = slot.faults().set_plan(request->plan_text());
      if (!found.empty()) return {StatusCode::INVALID_ARGUMENT, in_short(to_string(found))};
      return shown(slot, *info);
    });
  }

  Status GetFaultPlan(ServerContext*, const v1::GetFaultPlanRequest* in, v1::FaultPlanInfo* out) override {
    return show(in, out);
  }

  Status GetFaultLog(ServerContext*, const v1::GetFaultLogRequest* request, v1::FaultLog* log) override {
    return on_board(*request, [&](BoardSlot& slot) {
      log->set_board(slot.index());
      for (v1::PlannedFault& fault : slot.faults().log(request->clear())) *log->add_faults() = std::move(fault);
      return Status::OK;
    });
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    stopped_.notify_all();
  }

 private:
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
  std::atomic<int> watchers_{0};
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stopping_ = false;
};

// Asks every call for the token, those of health and reflection too.
class TokenCheck final : public grpc::AuthMetadataProcessor {
 public:
  explicit TokenCheck(std::string token) : token_(std::move(token)) {}

  bool IsBlocking() const override { return false; }

  Status Process(const InputMetadata& metadata, grpc::AuthContext*, OutputMetadata* consumed,
                 OutputMetadata*) override {
    const auto found = metadata.find("authorization");
    const bool is_good = found != metadata.end() && is_authorized({found->second.data(), found->second.size()}, token_);
    if (!is_good) return {StatusCode::UNAUTHENTICATED, "expected the metadata \"authorization: Bearer TOKEN\""};
    consumed->insert({"authorization", std::string(found->second.data(), found->second.size())});
    return Status::OK;
  }

 private:
  const std::string token_;
};

std::string read_pem(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{}: can't be read", path));
  return {std::istreambuf_iterator<char>(file), {}};
}

std::shared_ptr<grpc::ServerCredentials> credentials(const ManagementOptions& options) {
  if (options.certificate_file.empty()) return grpc::InsecureServerCredentials();
  grpc::SslServerCredentialsOptions tls;
  tls.pem_key_cert_pairs.push_back({read_pem(options.key_file), read_pem(options.certificate_file)});
  auto secured = grpc::SslServerCredentials(tls);
  secured->SetAuthMetadataProcessor(std::make_shared<TokenCheck>(read_token(options.token_file)));
  return secured;
}

}  // namespace

std::string read_token(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw std::runtime_error(fmt::format("{}: {}", path, std::generic_category().message(errno)));
  struct stat status {};
  const bool is_file = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
  const bool is_private = is_file && (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  std::array<char, 4096> bytes{};
  const ssize_t size = is_private ? ::read(fd, bytes.data(), bytes.size()) : 0;
  ::close(fd);
  if (!is_file) throw std::runtime_error(fmt::format("{}: expected a file with a token", path));
  if (!is_private) {
    throw std::runtime_error(fmt::format("{}: expected a file that only its owner can read (mode 600), got mode {:o}",
                                         path, status.st_mode & 0777u));
  }
  std::string token(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
  if (token.size() < kMinTokenBytes || token.size() >= bytes.size()) {
    throw std::runtime_error(fmt::format("{}: expected a token of {} to {} characters, got {}", path, kMinTokenBytes,
                                         bytes.size() - 1, token.size()));
  }
  return token;
}

bool is_authorized(std::string_view authorization, std::string_view token) {
  constexpr std::string_view kScheme = "Bearer ";
  if (!authorization.starts_with(kScheme)) return false;
  authorization.remove_prefix(kScheme.size());
  // Only the length, which is no secret, can end it early.
  if (authorization.size() != token.size()) return false;
  std::uint8_t difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i) {
    difference = static_cast<std::uint8_t>(difference | (static_cast<std::uint8_t>(authorization[i] ^ token[i])));
  }
  return difference == 0;
}

std::vector<Diagnostic> check(const ManagementOptions& options) {
  const std::array<std::pair<const char*, const std::string*>, 3> files{
      {{"--management-cert", &options.certificate_file},
       {"--management-key", &options.key_file},
       {"--management-token-file", &options.token_file}}};
  std::string missing;
  int given = 0;
  for (const auto& [flag, file] : files) {
    if (file->empty()) missing += (missing.empty() ? "" : ", ") + std::string(flag);
    given += file->empty() ? 0 : 1;
  }
  std::vector<Diagnostic> found;
  const std::string endpoint = to_string(options.endpoint);
  if (options.endpoint.kind == EndpointKind::kFd) {
    found.push_back({"--management", "unix:PATH or tcp:HOST:PORT", endpoint});
  } else if (!is_local(options.endpoint) && !missing.empty()) {
    found.push_back({"--management",
                     fmt::format("a loopback address or a unix socket, or TLS and a token by {}", missing),
                     endpoint + ", which other machines can reach"});
  } else if (given != 0 && !missing.empty()) {
    found.push_back({"--management", "a certificate, a key and a token file together; missing: " + missing,
                     fmt::format("{} of the three", given)});
  }
  return found;
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
  Service service;
  std::unique_ptr<grpc::Server> server;

  Parts(std::vector<BoardSlot*> boards, const std::string& trace_folder) : service(std::move(boards), trace_folder) {}
};

Management::Management(const ManagementOptions& options, std::vector<BoardSlot*> boards)
    : parts_(std::make_unique<Parts>(std::move(boards), options.trace_folder)) {
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
  int port = 0;
  const std::string text = to_string(options.endpoint);
  builder.AddListeningPort(is_unix ? text : text.substr(std::string("tcp:").size()), credentials(options), &port);
  builder.RegisterService(&parts_->service);
  parts_->server = builder.BuildAndStart();
  if (!parts_->server)
    throw std::runtime_error(fmt::format("{}: can't listen there, or the certificate is no good", text));
  parts_->endpoint = options.endpoint;
  if (!is_unix) parts_->endpoint.port = static_cast<std::uint16_t>(port);
  grpc::HealthCheckServiceInterface* health = parts_->server->GetHealthCheckService();
  health->SetServingStatus(v1::BoardManagement::service_full_name(), true);
}

Management::~Management() {
  if (!parts_->server) return;
  parts_->server->GetHealthCheckService()->SetServingStatus(false);
  parts_->service.stop();
  parts_->server->Shutdown(std::chrono::system_clock::now() + kShutdownGrace);
  parts_->server->Wait();
}

const Endpoint& Management::endpoint() const { return parts_->endpoint; }

}  // namespace gicube::emu
