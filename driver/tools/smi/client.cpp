#include "client.h"

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <charconv>
#include <chrono>
#include <fstream>
#include <iterator>

#include "gicube/access.h"
#include "local_boards.h"

namespace gicube::smi {
namespace {

constexpr std::chrono::seconds kPatience{20};  // chosen: a reset waits for the owner's running work

std::string target_of(const std::string& endpoint) {
  if (endpoint.starts_with("unix:") && endpoint.size() > 5) return endpoint;
  if (endpoint.starts_with("tcp:") && endpoint.rfind(':') > 4) {
    // The host name that gicube-board accepts: another user's program may listen at the same port of [::1].
    constexpr std::string_view kLocalhost = "tcp:localhost:";
    return endpoint.starts_with(kLocalhost) ? "127.0.0.1:" + endpoint.substr(kLocalhost.size()) : endpoint.substr(4);
  }
  throw UsageError(fmt::format("--management: expected unix:PATH or tcp:HOST:PORT, got \"{}\"", endpoint));
}

// The address of a TCP endpoint of this machine, without brackets; empty for other machines.
std::string local_address(const std::string& endpoint) {
  if (!endpoint.starts_with("tcp:")) return {};
  const std::string target = target_of(endpoint);
  std::string host = target.substr(0, target.rfind(':'));
  if (host == "[::1]") return "::1";
  return host.starts_with("127.") ? host : "";
}

std::uint16_t port_of(const std::string& endpoint) {
  std::uint16_t port = 0;
  const char* const begin = endpoint.data() + endpoint.rfind(':') + 1;
  std::from_chars(begin, endpoint.data() + endpoint.size(), port);
  return port;
}

std::string token_in(const std::string& file) {
  try {
    return read_tokens(file).front().token;
  } catch (const std::runtime_error& error) {
    throw UsageError(fmt::format("--token-file: {}", error.what()));
  }
}

}  // namespace

std::string read_file(const char* option, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw UsageError(fmt::format("{}: expected a readable file, got {}", option, path));
  return text;
}

Client::Client(const Options& options)
    : endpoint_(options.management.empty() ? only_management_endpoint() : options.management), board_(options.board) {
  std::shared_ptr<grpc::ChannelCredentials> credentials = grpc::InsecureChannelCredentials();
  const bool is_local = !local_address(endpoint_).empty();
  if (!options.token_file.empty()) {
    if (options.ca_file.empty() && !is_local) {
      throw UsageError(
          "--ca: expected the board's certificate beside --token-file: over a network a token is sent by TLS only");
    }
    token_ = token_in(options.token_file);
  } else if (is_local) {
    token_ = local_token(local_address(endpoint_), port_of(endpoint_));
  }
  if (!options.ca_file.empty()) {
    grpc::SslCredentialsOptions tls;
    tls.pem_root_certs = read_file("--ca", options.ca_file);
    credentials = grpc::SslCredentials(tls);
  }
  stub_ = v1::BoardManagement::NewStub(grpc::CreateChannel(target_of(endpoint_), credentials));
}

void Client::prepare(grpc::ClientContext& context, bool limited) const {
  if (!token_.empty()) context.AddMetadata("authorization", "Bearer " + token_);
  if (limited) context.set_deadline(std::chrono::system_clock::now() + kPatience);
}

void Client::check(const grpc::Status& status) const {
  switch (status.error_code()) {
    case grpc::StatusCode::OK: return;
    case grpc::StatusCode::UNAVAILABLE:
      throw CallFailed(
          fmt::format("nobody answers on {} ({}). Is a gicube-board running that was started with --management {}?",
                      endpoint_, status.error_message(), endpoint_));
    case grpc::StatusCode::UNAUTHENTICATED:
      throw CallFailed(fmt::format("{} asks for a token: --token-file ({})", endpoint_, status.error_message()));
    case grpc::StatusCode::UNIMPLEMENTED:
      throw CallFailed(fmt::format("{} does not know this call: it is older than this program", endpoint_));
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      throw CallFailed(fmt::format("{} does not answer: {}", endpoint_, status.error_message()));
    default: throw CallFailed(status.error_message());
  }
}

void Client::watch(std::uint32_t interval_ms, const std::function<bool(const v1::CounterSnapshot&)>& each) {
  grpc::ClientContext context;
  prepare(context, false);
  v1::WatchCountersRequest request;
  request.set_board(board_);
  request.set_interval_ms(interval_ms);
  const auto reader = stub_->WatchCounters(&context, request);
  bool goes_on = true;
  for (v1::CounterSnapshot snapshot; reader->Read(&snapshot);) {
    if (!goes_on) continue;  // these snapshots arrived before the cancellation
    goes_on = each(snapshot);
    if (!goes_on) context.TryCancel();
  }
  const grpc::Status status = reader->Finish();
  if (goes_on) check(status);
}

void Client::debug(const std::function<std::optional<std::string>()>& next,
                   const std::function<void(const v1::DebugAnswer&)>& each) {
  grpc::ClientContext context;
  prepare(context, false);
  const auto stream = stub_->Debug(&context);
  v1::DebugRequest request;
  request.set_board(board_);
  while (const auto line = next()) {
    request.set_line(*line);
    v1::DebugAnswer answer;
    if (!stream->Write(request) || !stream->Read(&answer)) break;
    each(answer);
  }
  stream->WritesDone();
  check(stream->Finish());
}

}  // namespace gicube::smi
