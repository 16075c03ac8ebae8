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
// A file that an option names or, where that is empty, an environment variable; and what a message calls it.
struct NamedFile {
  std::string path;  // empty: neither does
  std::string field;
};
NamedFile named_file(const std::string& option, const char* field, const char* variable);
// The first token of the file that OpenOptions::token_file names, or what stands for it; empty: none is named. Throws
// BadArgument if that file has none.
std::string named_token(const std::string& token_file);
// The access token for the board that this socket is connected to: the first of OpenOptions::token_file, or what stands
// for it; empty: none, as for another machine without TLS. Throws BadArgument if that file has none.
std::string access_token(int socket, bool is_secure, const std::string& token_file);
// Returns the system's error instead of throwing OpenFailed or TimedOut; would_block: the watchdog expired.
Fd try_to_connect(const Uri& uri, std::chrono::milliseconds watchdog, boost::system::error_code& result);

}  // namespace gicube
