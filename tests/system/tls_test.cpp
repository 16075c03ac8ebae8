// The data plane by TLS: a board process with a certificate, and drivers that trust it or not.
#include <sys/stat.h>

#include <exception>

#include "board_process.h"
#include "gicube/board.h"
#include "raw_client.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::system_test {
namespace {

class TlsBoard : public testing::Test {
 protected:
  void SetUp() override {
    if (!make_certificate("board", "IP:127.0.0.1,DNS:localhost") || !make_certificate("other", "IP:127.0.0.1")) {
      GTEST_SKIP() << "the openssl command is missing or too old";
    }
    ::setenv("GICUBE_CA_FILE", folder_.file("board.pem").c_str(), 1);
  }
  void TearDown() override { ::unsetenv("GICUBE_CA_FILE"); }

  bool make_certificate(const std::string& name, const std::string& names) const {
    return std::system(("openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=" + name +
                        " -addext subjectAltName=" + names + " -keyout " + folder_.file(name + ".key") + " -out " +
                        folder_.file(name + ".pem") + " 2>/dev/null")
                           .c_str()) == 0;
  }
  // Where drivers open it.
  std::string start(const std::string& certificate = "board", const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--listen",   "tcp:127.0.0.1:0",
                                       "--tls-cert", folder_.file(certificate + ".pem"),
                                       "--tls-key",  folder_.file(certificate + ".key")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    process_.emplace(arguments);
    const std::string line = process_->read_line();
    EXPECT_THAT(line, HasSubstr("ready on tls:127.0.0.1:"));
    return line.substr(line.find("tls:"));
  }

  reference::TemporaryDirectory folder_;
  std::optional<BoardProcess> process_;
};

TEST_F(TlsBoard, IsOpenedByDriversThatTrustItsCertificateAndWorksAsOthers) {
  const std::string uri = start();
  Board board = Board::open(uri);
  const std::vector<std::byte> samples(32 * 32 * 32, std::byte{9});  // more than one record of TLS
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {32, 32, 32}});
  Board plain = Board::open("emu:");
  plain.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {32, 32, 32}});
  EXPECT_EQ(board.now(), plain.now());
  EXPECT_EQ(board.counters().value("bus.down.bytes"), plain.counters().value("bus.down.bytes"));
}

TEST_F(TlsBoard, ASessionGoesOnOverANewConnection) {
  const std::string plan = folder_.file("plan");
  std::ofstream(plan) << "fault { direction: up message: 5 kind: link_loss }\n";
  OpenOptions options;
  options.reopen_attempts = 3;
  Board board = Board::open(start("board", {"--faults", plan}), options);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(board.counters().has("bus.down.bytes"));
}

TEST_F(TlsBoard, IsNotOpenedIfItsCertificateIsNotTrustedOrNotForThatHost) {
  EXPECT_THROWS(OpenFailed, "certificate verify failed", Board::open(start("other")));
  ASSERT_TRUE(make_certificate("elsewhere", "DNS:elsewhere.invalid"));
  ::setenv("GICUBE_CA_FILE", folder_.file("elsewhere.pem").c_str(), 1);
  EXPECT_THROWS(OpenFailed, "certificate verify failed", Board::open(start("elsewhere")));
  ::setenv("GICUBE_CA_FILE", "/nowhere", 1);
  EXPECT_THROWS(BadArgument, "GICUBE_CA_FILE", Board::open("tls:127.0.0.1:1"));
}

TEST_F(TlsBoard, IsOpenedByTheCertificateThatTheOptionsName) {
  const std::string uri = start();
  ::setenv("GICUBE_CA_FILE", "/nowhere", 1);
  OpenOptions options;
  options.ca_file = folder_.file("board.pem");
  EXPECT_TRUE(Board::open(uri, options).counters().has("bus.down.bytes"));
  options.ca_file = "/nowhere/either";
  EXPECT_THROWS(BadArgument, "ca_file: expected a file", Board::open(uri, options));
}

TEST_F(TlsBoard, PlainBytesAreAnsweredByNoFrameAndHurtNobody) {
  const std::string uri = start();
  const auto port = static_cast<std::uint16_t>(std::stoi(uri.substr(uri.rfind(':') + 1)));
  for (int i = 0; i < 40; ++i) {
    reference::RawClient client = reference::RawClient::connect_tcp(port);
    bool answered = false;
    try {
      answered = client.handshake().has_value();
    } catch (const std::exception&) {  // an alert of TLS is no frame
    }
    EXPECT_FALSE(answered);
  }
  EXPECT_THROW(Board::open("tcp:127.0.0.1:" + std::to_string(port)), OpenFailed);
  EXPECT_TRUE(Board::open(uri).counters().has("bus.down.bytes"));
}

TEST_F(TlsBoard, DoesNotStartWithACertificateThatIsNone) {
  std::ofstream(folder_.file("none.pem")) << "no certificate\n";
  BoardProcess process(
      {"--listen", "tcp:127.0.0.1:0", "--tls-cert", folder_.file("none.pem"), "--tls-key", folder_.file("board.key")});
  EXPECT_EQ(process.exit_code(), 1);
  EXPECT_THAT(process.read_errors(), HasSubstr("none.pem: "));
}

}  // namespace
}  // namespace gicube::system_test
