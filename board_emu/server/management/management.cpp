#include "management.h"

#include <fmt/format.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "service.h"

namespace gicube::emu {
namespace {

constexpr std::chrono::milliseconds kShutdownGrace{200};  // chosen: with the final messages to clients below kMaxEnding
constexpr int kMaxMessageBytes = 2 << 20;                 // chosen: twice the maximum size of a configuration text
constexpr int kMaxThreads = 48;                           // chosen: three times the watches; each call needs one
constexpr int kMaxCallsOfConnection = 32;                 // chosen: twice the watches; further calls wait
constexpr std::size_t kMaxMemoryBytes = std::size_t{64} << 20;  // chosen: a configuration for each of 32 calls

std::string read_pem(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{}: expected a readable file", path));
  return {std::istreambuf_iterator<char>(file), {}};
}

// `check`: for callers over TCP.
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
    throw std::invalid_argument("file: expected none, because the board process has no --trace-dir, got " + file);
  }
  const std::filesystem::path path(file);
  const std::string name = path.filename().string();
  const bool is_there = !path.has_parent_path() || path.parent_path() == folder;
  // With a zero byte, the name in the log would differ from the name of the written file.
  const bool is_text = std::ranges::none_of(file, [](unsigned char c) { return c < ' ' || c == 0x7f; });
  if (!is_text) throw std::invalid_argument("file: expected a name without control characters, got one with them");
  if (!is_there || name.empty() || name.starts_with('.')) {
    throw std::invalid_argument(fmt::format("file: expected the name of a new file in {}, got {}", folder, file));
  }
  return (std::filesystem::path(folder) / name).string();
}

struct Management::Parts {
  Endpoint endpoint;
  std::shared_ptr<TokenCheck> tokens;  // null for a Unix socket, whose file only its owner can access
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
  // Otherwise a second process would silently share the port.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  // Calls beyond these limits end with RESOURCE_EXHAUSTED.
  grpc::ResourceQuota quota("management");
  quota.SetMaxThreads(kMaxThreads);
  quota.Resize(kMaxMemoryBytes);
  builder.SetResourceQuota(quota);
  builder.SetSyncServerOption(grpc::ServerBuilder::NUM_CQS, 1);  // default: one per core, with its own threads
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxCallsOfConnection);
  int port = 0;
  const std::string text = to_string(options.endpoint);
  builder.AddListeningPort(is_unix ? text : text.substr(std::string("tcp:").size()),
                           credentials(options, parts_->tokens), &port);
  builder.RegisterService(&parts_->service);
  parts_->server = builder.BuildAndStart();
  if (!parts_->server)
    throw std::runtime_error(fmt::format("{}: cannot listen there, or the certificate is not valid", text));
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
