// Connects to a board that listens on a Unix socket or on TCP.
#pragma once

#include <chrono>

#include "fd.h"
#include "uri.h"

namespace gicube {

// `watchdog`: wall-clock limit for the connection; 0 = none. Only for unix: and tcp: URIs.
// Throws OpenFailed (nobody listens there), TimedOut, and BadArgument for a Unix path that is too long.
Fd connect(const Uri& uri, std::chrono::milliseconds watchdog);

}  // namespace gicube
