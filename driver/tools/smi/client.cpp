#include "client.h"

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <fstream>
#include <iterator>

#include "local_boards.h"

namespace gicube::smi {
namespace {

constexpr std::chrono::seconds kPatience{20};  // chosen: a reset waits for the owner's running work

std::string target_of(const std::string& endpoint) {
  if (endpoint.starts_with("unix:") && endpoint.size() > 5) return endpoint;
  if (endpoint.starts_with("tcp:") && endpoint.rfind(':') > 4) return endpoint.substr(4);
  throw UsageError(fmt::format("--management: expected unix:PATH or tcp:HOST:PORT, got \"{}\"", endpoint));
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
  if (options.ca_file.empty() != options.token_file.empty()) {
    throw UsageError("--ca, --token-file: expected both or none: a board that asks for one has the other");
  }
  std::shared_ptr<grpc::ChannelCredentials> credentials = grpc::InsecureChannelCredentials();
  if (!options.ca_file.empty()) {
    token_ = read_file("--token-file", options.token_file);
    token_.erase(token_.find_last_not_of(" \r\n\t") + 1);
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
    if (!goes_on) continue;  // what came before the cancellation
    goes_on = each(snapshot);
    if (!goes_on) context.TryCancel();
  }
  const grpc::Status status = reader->Finish();
  if (goes_on) check(status);
}

}  // namespace gicube::smi
