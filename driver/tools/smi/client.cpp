#include "client.h"

#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <fstream>
#include <iterator>

namespace gicube::smi {
namespace {

constexpr std::chrono::seconds kPatience{20};  // chosen: a reset waits for the owner's running work

std::string read_file(const char* option, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw UsageError(fmt::format("{}: expected a readable file, got {}", option, path));
  return text;
}

std::string target_of(const std::string& endpoint) {
  if (endpoint.starts_with("unix:") && endpoint.size() > 5) return endpoint;
  if (endpoint.starts_with("tcp:") && endpoint.rfind(':') > 4) return endpoint.substr(4);
  throw UsageError(fmt::format("--management: expected unix:PATH or tcp:HOST:PORT, got \"{}\"", endpoint));
}

}  // namespace

Client::Client(const Options& options) : endpoint_(options.management), board_(options.board) {
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

void Client::prepare(grpc::ClientContext& context) const {
  if (!token_.empty()) context.AddMetadata("authorization", "Bearer " + token_);
}

void Client::fail(const grpc::Status& status) const {
  switch (status.error_code()) {
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

template <typename Request, typename Response>
Response Client::call(grpc::Status (v1::BoardManagement::Stub::*method)(grpc::ClientContext*, const Request&,
                                                                        Response*),
                      Request request) {
  grpc::ClientContext context;
  prepare(context);
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  Response response;
  const grpc::Status status = (stub_.get()->*method)(&context, request, &response);
  if (!status.ok()) fail(status);
  return response;
}

namespace {

template <typename Request>
Request about(std::uint32_t board) {
  Request request;
  request.set_board(board);
  return request;
}

}  // namespace

using Stub = v1::BoardManagement::Stub;

v1::ListBoardsResponse Client::list() { return call(&Stub::ListBoards, v1::ListBoardsRequest{}); }
v1::BoardInfo Client::info() { return call(&Stub::GetInfo, about<v1::GetInfoRequest>(board_)); }
v1::BoardInfo Client::reset() { return call(&Stub::Reset, about<v1::ResetRequest>(board_)); }
v1::CounterSnapshot Client::counters() { return call(&Stub::GetCounters, about<v1::GetCountersRequest>(board_)); }
v1::FaultPlanInfo Client::fault_plan() { return call(&Stub::GetFaultPlan, about<v1::GetFaultPlanRequest>(board_)); }

v1::FaultPlanInfo Client::set_fault_plan(const std::string& text) {
  auto request = about<v1::SetFaultPlanRequest>(board_);
  request.set_plan_text(text);
  return call(&Stub::SetFaultPlan, request);
}

v1::FaultLog Client::fault_log(bool clear) {
  auto request = about<v1::GetFaultLogRequest>(board_);
  request.set_clear(clear);
  return call(&Stub::GetFaultLog, request);
}

v1::TraceInfo Client::trace() { return call(&Stub::GetTrace, about<v1::GetTraceRequest>(board_)); }

v1::TraceInfo Client::set_trace(const std::string& file) {
  auto request = about<v1::SetTraceRequest>(board_);
  request.set_file(file);
  return call(&Stub::SetTrace, request);
}

void Client::watch(std::uint32_t interval_ms, const std::function<bool(const v1::CounterSnapshot&)>& each) {
  grpc::ClientContext context;
  prepare(context);
  auto request = about<v1::WatchCountersRequest>(board_);
  request.set_interval_ms(interval_ms);
  const auto reader = stub_->WatchCounters(&context, request);
  v1::CounterSnapshot snapshot;
  while (reader->Read(&snapshot)) {
    if (each(snapshot)) continue;
    context.TryCancel();
    while (reader->Read(&snapshot)) {
    }
    reader->Finish();
    return;
  }
  const grpc::Status status = reader->Finish();
  if (!status.ok()) fail(status);
}

}  // namespace gicube::smi
