// The management plane's client: calls with a deadline, faults in words.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "gicube/v1/management.grpc.pb.h"
#include "options.h"

namespace gicube::smi {

// A call failed: exit code 1.
class CallFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Client {
 public:
  // Reads the certificate and the token that `options` name. Throws UsageError; connects with the first call.
  explicit Client(const Options& options);

  // All throw CallFailed that names the endpoint and says what to do.
  v1::ListBoardsResponse list();
  v1::BoardInfo info();
  v1::BoardInfo reset();
  v1::CounterSnapshot counters();
  // Calls `each` for every snapshot until it answers false.
  void watch(std::uint32_t interval_ms, const std::function<bool(const v1::CounterSnapshot&)>& each);
  v1::FaultPlanInfo fault_plan();
  v1::FaultPlanInfo set_fault_plan(const std::string& text);
  v1::FaultLog fault_log(bool clear);
  v1::TraceInfo trace();
  v1::TraceInfo set_trace(const std::string& file);

  const std::string& endpoint() const { return endpoint_; }

 private:
  template <typename Request, typename Response>
  Response call(grpc::Status (v1::BoardManagement::Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                Request request);
  void prepare(grpc::ClientContext& context) const;
  [[noreturn]] void fail(const grpc::Status& status) const;

  std::string endpoint_;
  std::string token_;
  std::uint32_t board_;
  std::unique_ptr<v1::BoardManagement::Stub> stub_;
};

}  // namespace gicube::smi
