// Connects to a board that listens on a Unix socket or on TCP.
#pragma once

#include <boost/system/error_code.hpp>
#include <chrono>
#include <string>

#include "fd.h"
#include "uri.h"

namespace gicube {

// `watchdog`: wall-clock limit for the connection; 0 = none. Only for unix: and tcp: URIs.
// Throws OpenFailed (nobody listens there), TimedOut, and BadArgument for a Unix path that is too long.
Fd connect(const Uri& uri, std::chrono::milliseconds watchdog);
// A file that is named by an option or, if that is empty, by an environment variable; and what messages call it.
struct NamedFile {
  std::string path;  // empty: neither names one
  std::string field;
};
NamedFile named_file(const std::string& option, const char* field, const char* variable);
// The first token in the file that OpenOptions::token_file or, if that is empty, GICUBE_TOKEN_FILE names. Empty:
// neither names a file. Throws BadArgument if the file has no token.
std::string named_token(const std::string& token_file);
// The access token for the board that this socket is connected to: the one above or, without one, the token of this
// user's board at that address. Empty for Unix sockets, and for another machine without TLS. Throws BadArgument if the
// file has no token.
std::string access_token(int socket, bool is_secure, const std::string& token_file);
// Returns the system's error instead of throwing OpenFailed or TimedOut; would_block: the watchdog expired.
Fd try_to_connect(const Uri& uri, std::chrono::milliseconds watchdog, boost::system::error_code& result);

}  // namespace gicube
