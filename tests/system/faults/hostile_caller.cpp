#include "hostile_caller.h"

#include <grpcpp/grpcpp.h>

#include <array>
#include <chrono>
#include <memory>
#include <random>
#include <string_view>
#include <thread>

#include "gicube/v1/management.grpc.pb.h"
#include "raw_client.h"

namespace gicube::system_test {
namespace {

using reference::RawClient;
using Random = std::mt19937_64;

struct Target {
  std::uint16_t port;
  const std::string& reader;
  Random random;
};

// One call over a connection of its own. True if the board carried it out.
template <typename Request, typename Answer>
bool call(const Target& target, const std::string& token,
          grpc::Status (v1::BoardManagement::Stub::*method)(grpc::ClientContext*, const Request&, Answer*),
          const Request& request) {
  grpc::ChannelArguments own;
  own.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto channel =
      grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(target.port), grpc::InsecureChannelCredentials(), own);
  v1::BoardManagement::Stub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  Answer answer;
  return (stub.*method)(&context, request, &answer).ok();
}

bool configure(const Target& target, const std::string& token, const std::string& text) {
  v1::ConfigureRequest request;
  request.set_config_text(text);
  return call(target, token, &v1::BoardManagement::Stub::Configure, request);
}

bool set_faults(const Target& target, const std::string& token, const std::string& text) {
  v1::SetFaultPlanRequest request;
  request.set_plan_text(text);
  return call(target, token, &v1::BoardManagement::Stub::SetFaultPlan, request);
}

bool reset(const Target& target, const std::string& token) {
  return call(target, token, &v1::BoardManagement::Stub::Reset, v1::ResetRequest());
}

void send_and_leave(const Target& target, std::string_view text) {
  RawClient client = RawClient::connect_tcp(target.port);
  client.send_bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

constexpr std::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

bool noise(Target& target) {
  std::string bytes(target.random() % 20'000, '\0');
  for (char& byte : bytes) byte = static_cast<char>(target.random());
  send_and_leave(target, bytes);
  return false;
}

bool another_protocol(Target& target) {
  send_and_leave(target, "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n");
  return false;
}

bool half_a_greeting(Target& target) {
  RawClient client = RawClient::connect_tcp(target.port);
  const std::size_t length = target.random() % kPreface.size();
  client.send_bytes({reinterpret_cast<const std::uint8_t*>(kPreface.data()), length});
  std::this_thread::sleep_for(std::chrono::milliseconds(target.random() % 40));
  return false;
}

// Frames of HTTP/2 of any length and type.
bool broken_frames(Target& target) {
  std::string bytes = std::string(kPreface) + std::string("\0\0\0\4\0\0\0\0\0", 9);
  for (int i = 0; i < 2000; ++i) bytes += static_cast<char>(target.random());
  send_and_leave(target, bytes);
  return false;
}

bool no_token(Target& target) { return configure(target, "", "threads: 1") || reset(target, ""); }
bool a_wrong_token(Target& target) { return reset(target, "token_that_nobody_was_given"); }
bool no_right(Target& target) {
  return reset(target, target.reader) || configure(target, target.reader, "threads: 1") ||
         set_faults(target, target.reader, "fault { direction: up message: 1 kind: kill }");
}

bool deep_text(Target& target) {
  std::string text;
  for (int i = 0; i < 120'000; ++i) text += "a{";
  return configure(target, target.reader, text) || set_faults(target, "", text);
}

bool a_huge_message(Target& target) { return configure(target, target.reader, std::string(8u << 20, 'x')); }

}  // namespace

int misbehave_at_management(std::uint16_t port, const std::string& reader, int way, std::uint64_t seed) {
  using Way = bool (*)(Target&);
  static constexpr std::array<Way, kHostileCalls> kWays{noise,         another_protocol, half_a_greeting,
                                                        broken_frames, no_token,         a_wrong_token,
                                                        no_right,      deep_text,        a_huge_message};
  Target target{port, reader, Random(seed)};
  return kWays.at(static_cast<std::size_t>(way))(target) ? 1 : 0;
}

}  // namespace gicube::system_test
