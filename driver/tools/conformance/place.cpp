#include "place.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cstdlib>
#include <system_error>
#include <thread>

#include "gicube/error.h"
#include "transport/connect.h"

namespace gicube::conformance {
namespace {

Fd listen_at(const std::string& path) {
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  constexpr int kBacklog = 64;
  if (socket.get() < 0 || ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket.get(), kBacklog) != 0) {
    throw OpenFailed("cannot listen at " + path + ": " + std::generic_category().message(errno));
  }
  return socket;
}

}  // namespace

Place::Place(const std::string& uri, std::chrono::milliseconds silence)
    : uri_(uri), parsed_(parse_uri(uri)), silence_(silence) {
  if (parsed_.scheme == UriScheme::kPci || parsed_.is_secure) {
    throw BadArgument("URI", "emu:, unix:PATH or tcp:HOST:PORT, whose bytes the suite sends itself", uri);
  }
  if (parsed_.scheme != UriScheme::kEmu) return;
  const std::string program = find_board_program();
  std::string name = (std::filesystem::temp_directory_path() / "gicube-conformance-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw OpenFailed("no folder for the board's socket: " + name);
  folder_ = name;
  const std::string path = folder_ / "board";
  child_ = std::make_unique<ChildProcess>(program, parsed_.board_arguments, listen_at(path));
  uri_ = "unix:" + path;
  parsed_ = parse_uri(uri_);
}

Place::~Place() {
  child_.reset();
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

RawClient Place::connect() const {
  Fd socket = gicube::connect(parsed_, silence_);
  ::fcntl(socket.get(), F_SETFL, ::fcntl(socket.get(), F_GETFL) & ~O_NONBLOCK);  // as Asio left it
  RawClient client(socket.release());
  client.limit_silence(silence_);
  return client;
}

}  // namespace gicube::conformance
