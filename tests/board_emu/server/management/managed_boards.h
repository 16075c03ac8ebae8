// Boards with a management plane on a unix socket, and a gRPC client of it.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "../bus/served_boards.h"
#include "gicube/v1/management.grpc.pb.h"
#include "server/management/management.h"

namespace gicube::emu {

// A call that hangs fails its test instead of hanging it.
class Call : public grpc::ClientContext {
 public:
  Call() { set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1)); }
};

class ManagedBoards {
 public:
  explicit ManagedBoards(std::uint32_t count = 1) : boards(count) {
    ManagementOptions options;
    options.endpoint = parse_endpoint("unix:" + boards.folder.file("management"));
    std::filesystem::create_directory(traces());
    options.trace_folder = traces();
    management = std::make_unique<Management>(options, boards.all());
    channel = grpc::CreateChannel(to_string(options.endpoint), grpc::InsecureChannelCredentials());
    stub = v1::BoardManagement::NewStub(channel);
  }

  std::string traces() const { return boards.folder.file("traces"); }

  grpc::Status configure(const std::string& text, v1::BoardInfo& info) {
    Call call;
    v1::ConfigureRequest request;
    request.set_config_text(text);
    return stub->Configure(&call, request, &info);
  }
  v1::BoardInfo info(std::uint32_t board = 0) {
    Call call;
    v1::GetInfoRequest request;
    request.set_board(board);
    v1::BoardInfo answer;
    EXPECT_TRUE(stub->GetInfo(&call, request, &answer).ok());
    return answer;
  }
  grpc::Status set_fault_plan(const std::string& text, v1::FaultPlanInfo& info) {
    Call call;
    v1::SetFaultPlanRequest request;
    request.set_plan_text(text);
    return stub->SetFaultPlan(&call, request, &info);
  }
  v1::FaultLog fault_log(bool clear = false) {
    Call call;
    v1::GetFaultLogRequest request;
    request.set_clear(clear);
    v1::FaultLog log;
    EXPECT_TRUE(stub->GetFaultLog(&call, request, &log).ok());
    return log;
  }
  grpc::Status reset(v1::BoardInfo& answer) {
    Call call;
    return stub->Reset(&call, {}, &answer);
  }

  ServedBoards boards;
  std::unique_ptr<Management> management;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::BoardManagement::Stub> stub;
};

}  // namespace gicube::emu
