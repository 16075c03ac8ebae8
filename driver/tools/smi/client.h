// The management plane's client: calls with a deadline, errors as texts.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "gicube/v1/management.grpc.pb.h"
#include "options.h"

namespace gicube::smi {

// A call failed: exit code 1. The text has the endpoint and advice.
struct CallFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

using Stub = v1::BoardManagement::Stub;

class Client {
 public:
  // Reads the certificate and the token that `options` name. Throws UsageError; connects with the first call.
  explicit Client(const Options& options);

  // A call of the service, as call(&Stub::GetInfo), about the board that the options name. Throws CallFailed.
  template <typename Request, typename Response>
  // NOLINTNEXTLINE(performance-unnecessary-value-param): it gets the board's number, if it has a field for one
  Response call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*), Request request = {}) {
    if constexpr (requires { request.set_board(0); }) request.set_board(board_);
    grpc::ClientContext context;
    prepare(context, true);
    Response response;
    check((stub_.get()->*method)(&context, request, &response));
    return response;
  }
  // Attaches a debugger and sends each line of `next` until it has none; `each` gets the answers. Throws CallFailed.
  void debug(const std::function<std::optional<std::string>()>& next,
             const std::function<void(const v1::DebugAnswer&)>& each);
  // Calls `each` for every snapshot until it answers false. Throws CallFailed.
  void watch(std::uint32_t interval_ms, const std::function<bool(const v1::CounterSnapshot&)>& each);

 private:
  void prepare(grpc::ClientContext& context, bool limited) const;
  void check(const grpc::Status& status) const;

  std::string endpoint_;
  std::string token_;
  std::uint32_t board_;
  std::unique_ptr<Stub> stub_;
};

}  // namespace gicube::smi
