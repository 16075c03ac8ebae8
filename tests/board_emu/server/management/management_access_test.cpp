// Who may call the management plane, and the standard services beside it.
#include <grpcpp/generic/generic_stub.h>
#include <sys/stat.h>

#include "managed_boards.h"
#include "test.h"

namespace gicube::emu {
namespace {

using grpc::StatusCode;

constexpr const char* kToken = "0123456789abcdef0123";

grpc::ByteBuffer bytes(const std::string& text) {
  const grpc::Slice slice(text);
  return {&slice, 1};
}

std::string text(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string all;
  if (!buffer.Dump(&slices).ok()) return all;
  for (const grpc::Slice& slice : slices) all.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return all;
}

// One message to and from a method of which we have no generated stub; messages are in protobuf's wire format.
grpc::Status call_raw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                      const std::string& request, std::string& response, const std::string& authorization = "") {
  grpc::GenericStub stub(channel);
  grpc::CompletionQueue queue;
  Call call;
  if (!authorization.empty()) call.AddMetadata("authorization", authorization);
  const auto stream = stub.PrepareCall(&call, method, &queue);
  const auto finished = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  grpc::ByteBuffer answer;
  stream->StartCall(nullptr);
  bool going = finished();
  if (going) stream->Write(bytes(request), nullptr), going = finished();
  if (going) stream->WritesDone(nullptr), going = finished();
  if (going) stream->Read(&answer, nullptr), going = finished();
  if (going) response = text(answer);
  grpc::Status status;
  stream->Finish(&status, nullptr);
  finished();
  return status;
}

// HealthCheckRequest { string service = 1; }, HealthCheckResponse { ServingStatus status = 1; } with SERVING = 1
std::string health_request(const std::string& service) {
  return std::string("\x0a") + static_cast<char>(service.size()) + service;
}
const std::string kServing("\x08\x01", 2);

TEST(ManagementAccess, TheStandardHealthServiceSaysServing) {
  ManagedBoards managed;
  for (const std::string service : {"", "gicube.v1.BoardManagement"}) {
    std::string response;
    const auto status = call_raw(managed.channel, "/grpc.health.v1.Health/Check", health_request(service), response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(response, kServing);
  }
  std::string response;
  EXPECT_EQ(call_raw(managed.channel, "/grpc.health.v1.Health/Check", health_request("other"), response).error_code(),
            StatusCode::NOT_FOUND);
}

TEST(ManagementAccess, ReflectionListsTheServices) {
  ManagedBoards managed;
  std::string response;
  const std::string list_services("\x3a\x01*", 3);  // ServerReflectionRequest { string list_services = 7; }
  const auto status = call_raw(managed.channel, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                               list_services, response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_THAT(response, HasSubstr("gicube.v1.BoardManagement"));
  EXPECT_THAT(response, HasSubstr("grpc.health.v1.Health"));
}

std::string refusal(const ManagementOptions& options) {
  return message_of<std::runtime_error>([&] { const Management management(options, {}); });
}

TEST(ManagementAccess, AnAddressThatOthersReachNeedsTlsAndAToken) {
  ManagementOptions options;
  options.endpoint = parse_endpoint("tcp:0.0.0.0:0");
  EXPECT_THAT(refusal(options), HasSubstr("--tls-cert, --tls-key, --token-file"));
}

TEST(ManagementAccess, ASocketThatSomeoneServesIsNotTakenAway) {
  ManagedBoards managed;
  ManagementOptions options;
  options.endpoint = parse_endpoint("unix:" + managed.boards.folder.file("management"));
  EXPECT_THAT(refusal(options), HasSubstr("another process is listening"));
  EXPECT_EQ(managed.info().board(), 0u);
}

TEST(ManagementAccess, APortThatSomeoneServesIsNotShared) {
  ServedBoards boards;
  ManagementOptions options;
  options.endpoint = parse_endpoint("tcp:127.0.0.1:0");
  const Management first(options, boards.all());
  ASSERT_NE(first.endpoint().port, 0);
  options.endpoint = first.endpoint();
  EXPECT_THAT(refusal(options), HasSubstr("cannot listen there"));
}

// Loopback without TLS.
class TokensOfManagement : public testing::Test {
 protected:
  static constexpr const char* kReader = "token_of_who_may_read";
  static constexpr const char* kUser = "token_of_who_may_use";

  TokensOfManagement() {
    options_.endpoint = parse_endpoint("tcp:127.0.0.1:0");
    options_.audit = &audit_;
    options_.tokens = {{Right::kControl, kToken}, {Right::kUse, kUser}, {Right::kRead, kReader}};
    management_ = std::make_unique<Management>(options_, boards_.all());
    channel_ = grpc::CreateChannel(to_string(management_->endpoint()).substr(4), grpc::InsecureChannelCredentials());
  }

  // What comes of one call after the other with this token.
  template <typename Request, typename Response>
  StatusCode call(const std::string& token,
                  grpc::Status (v1::BoardManagement::Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                  const Request& request = {}) const {
    Call context;
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    Response response;
    const auto stub = v1::BoardManagement::NewStub(channel_);
    return (stub.get()->*method)(&context, request, &response).error_code();
  }

  // What has been noted, as "reset 1 ".
  std::string noted() const {
    std::string text;
    for (const auto& [event, count] : audit_.counts()) {
      if (count > 0) text += fmt::format("{} {} ", event, count);
    }
    return text;
  }

  Audit audit_;
  ServedBoards boards_;
  ManagementOptions options_;
  std::unique_ptr<Management> management_;
  std::shared_ptr<grpc::Channel> channel_;
};

using Stub = v1::BoardManagement::Stub;

TEST_F(TokensOfManagement, AreAskedOfEveryoneOnLoopbackToo) {
  EXPECT_EQ(call(kToken, &Stub::ListBoards), StatusCode::OK);
  EXPECT_EQ(call("", &Stub::ListBoards), StatusCode::UNAUTHENTICATED);
  EXPECT_EQ(call("0123456789abcdef0124", &Stub::ListBoards), StatusCode::UNAUTHENTICATED);
  std::string response;
  EXPECT_EQ(call_raw(channel_, "/grpc.health.v1.Health/Check", health_request(""), response).error_code(),
            StatusCode::UNAUTHENTICATED);
}

TEST_F(TokensOfManagement, ThatMayOnlyReadOrUseChangeNothing) {
  v1::ConfigureRequest configure;
  configure.set_config_text("asic { processors: 8 }");
  v1::GetFaultLogRequest clear;
  clear.set_clear(true);
  for (const char* token : {kReader, kUser}) {
    EXPECT_EQ(call(token, &Stub::GetInfo), StatusCode::OK);
    EXPECT_EQ(call(token, &Stub::GetCounters), StatusCode::OK);
    EXPECT_EQ(call(token, &Stub::GetFaultPlan), StatusCode::OK);
    EXPECT_EQ(call(token, &Stub::GetFaultLog), StatusCode::OK);
    EXPECT_EQ(call(token, &Stub::GetTrace), StatusCode::OK);
    EXPECT_EQ(call(token, &Stub::Configure, configure), StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(call(token, &Stub::Reset), StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(call(token, &Stub::SetFaultPlan), StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(call(token, &Stub::SetTrace), StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(call(token, &Stub::SaveCheckpoint), StatusCode::PERMISSION_DENIED);
    EXPECT_EQ(call(token, &Stub::GetFaultLog, clear), StatusCode::PERMISSION_DENIED);
    Call context;
    context.AddMetadata("authorization", "Bearer " + std::string(token));
    const auto stub = v1::BoardManagement::NewStub(channel_);
    EXPECT_EQ(stub->Debug(&context)->Finish().error_code(), StatusCode::PERMISSION_DENIED);
  }
  EXPECT_EQ(boards_.all()[0]->info().config.asic().processors(), 4u);
  EXPECT_EQ(call(kToken, &Stub::Configure, configure), StatusCode::OK);
  EXPECT_EQ(call(kToken, &Stub::GetFaultLog, clear), StatusCode::OK);
  EXPECT_EQ(noted(), "forbidden 14 configured 1 ");
}

TEST_F(TokensOfManagement, WhatTheirHoldersDoIsNoted) {
  EXPECT_EQ(call("", &Stub::ListBoards), StatusCode::UNAUTHENTICATED);
  EXPECT_EQ(call(kToken, &Stub::Reset), StatusCode::OK);
  EXPECT_EQ(call(kToken, &Stub::SetFaultPlan), StatusCode::OK);
  v1::SetTraceRequest trace;
  trace.set_file("/tmp/anywhere");
  EXPECT_EQ(call(kToken, &Stub::SetTrace, trace), StatusCode::INVALID_ARGUMENT);
  v1::SaveCheckpointRequest checkpoint;
  checkpoint.set_file("/tmp/anywhere");
  EXPECT_EQ(call(kToken, &Stub::SaveCheckpoint, checkpoint), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(call(kToken, &Stub::GetCounters), StatusCode::OK);
  EXPECT_EQ(noted(), "unknown 1 reset 1 traced 1 saved 1 faults_set 1 ");
}

TEST(ManagementAccess, OnlyABearersTokenIsOne) {
  EXPECT_EQ(bearer_token("Bearer 0123456789abcdef"), "0123456789abcdef");
  for (const char* wrong : {"", "Bearer ", "bearer 0123456789abcdef", "0123456789abcdef"}) {
    EXPECT_EQ(bearer_token(wrong), "") << wrong;
  }
}

class SecuredManagement : public testing::Test {
 protected:
  void SetUp() override {
    const std::string make_certificate =
        "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=IP:127.0.0.1 "
        "-keyout " +
        options_.key_file + " -out " + options_.certificate_file + " 2>/dev/null";
    if (std::system(make_certificate.c_str()) != 0) GTEST_SKIP() << "the openssl command is missing or too old";
    write_token(0600);
  }

  void write_token(mode_t mode) const {
    std::ofstream(options_.token_file) << kToken << "\n";
    ::chmod(options_.token_file.c_str(), mode);
  }

  std::string certificate() const {
    std::ifstream file(options_.certificate_file);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static std::string address(const Management& management) { return to_string(management.endpoint()).substr(4); }

  std::shared_ptr<grpc::Channel> secure_channel(const Management& management) const {
    grpc::SslCredentialsOptions tls;
    tls.pem_root_certs = certificate();
    return grpc::CreateChannel(address(management), grpc::SslCredentials(tls));
  }

  static grpc::Status list(const std::shared_ptr<grpc::Channel>& channel, const std::string& authorization) {
    Call call;
    if (!authorization.empty()) call.AddMetadata("authorization", authorization);
    v1::ListBoardsResponse response;
    return v1::BoardManagement::NewStub(channel)->ListBoards(&call, {}, &response);
  }

  ServedBoards boards_;
  ManagementOptions options_{parse_endpoint("tcp:127.0.0.1:0"), boards_.folder.file("cert.pem"),
                             boards_.folder.file("key.pem"), boards_.folder.file("token")};
};

TEST_F(SecuredManagement, LetsInWhoeverHasTheToken) {
  const Management management(options_, boards_.all());
  const grpc::Status status = list(secure_channel(management), std::string("Bearer ") + kToken);
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(SecuredManagement, TurnsAwayEveryoneElseAndFromEveryService) {
  const Management management(options_, boards_.all());
  const auto channel = secure_channel(management);
  EXPECT_EQ(list(channel, "").error_code(), StatusCode::UNAUTHENTICATED);
  EXPECT_EQ(list(channel, "Bearer 0123456789abcdef0124").error_code(), StatusCode::UNAUTHENTICATED);
  std::string response;
  EXPECT_EQ(call_raw(channel, "/grpc.health.v1.Health/Check", health_request(""), response).error_code(),
            StatusCode::UNAUTHENTICATED);
  EXPECT_TRUE(
      call_raw(channel, "/grpc.health.v1.Health/Check", health_request(""), response, std::string("Bearer ") + kToken)
          .ok());
}

TEST_F(SecuredManagement, SpeaksNoPlainText) {
  const Management management(options_, boards_.all());
  const auto channel = grpc::CreateChannel(address(management), grpc::InsecureChannelCredentials());
  EXPECT_EQ(list(channel, std::string("Bearer ") + kToken).error_code(), StatusCode::UNAVAILABLE);
}

TEST_F(SecuredManagement, ListensBeyondThisMachineOnceAllIsGiven) {
  options_.endpoint = parse_endpoint("tcp:0.0.0.0:0");
  EXPECT_EQ(refusal(options_), "none");
}

TEST_F(SecuredManagement, RefusesATokenFileThatOthersCanRead) {
  write_token(0644);
  EXPECT_THAT(refusal(options_), HasSubstr("only its owner can read"));
}

TEST_F(SecuredManagement, RefusesFilesThatAreMissingOrNoCertificate) {
  ManagementOptions missing = options_;
  missing.key_file = boards_.folder.file("nothing");
  EXPECT_THAT(refusal(missing), HasSubstr("nothing: expected a readable file"));
  ManagementOptions swapped = options_;
  swapped.certificate_file = options_.token_file;
  EXPECT_THAT(refusal(swapped), HasSubstr("the certificate is not valid"));
}

}  // namespace
}  // namespace gicube::emu
