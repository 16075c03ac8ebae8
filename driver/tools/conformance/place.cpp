#include "place.h"

#include <fcntl.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cstdlib>
#include <system_error>

#include "gicube/error.h"
#include "transport/connect.h"

namespace gicube::conformance {

using boost::asio::local::stream_protocol;

Place::Place(const std::string& uri, std::chrono::milliseconds silence)
    : uri_(uri), parsed_(parse_uri(uri)), silence_(silence) {
  if (parsed_.scheme == UriScheme::kPci || parsed_.is_secure) {
    throw BadArgument("URI", "emu:, unix:PATH or tcp:HOST:PORT: the suite writes the bytes of the connection itself",
                      uri);
  }
  if (parsed_.scheme != UriScheme::kEmu) return;
  const std::string program = find_board_program();
  std::string name = (std::filesystem::temp_directory_path() / "gicube-conformance-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw OpenFailed("cannot create a folder for the board's socket: " + name);
  folder_ = name;
  const std::string path = folder_ / "board";
  boost::asio::io_context io;
  stream_protocol::acceptor listener(io, stream_protocol::endpoint(path));
  child_ = std::make_unique<ChildProcess>(program, parsed_.board_arguments, Fd(listener.release()));
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
  ::fcntl(socket.get(), F_SETFL, ::fcntl(socket.get(), F_GETFL) & ~O_NONBLOCK);  // which Asio has set
  RawClient client(socket.release());
  client.limit_silence(silence_);
  return client;
}

}  // namespace gicube::conformance
