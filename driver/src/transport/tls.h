// The client's end of TLS for a connection to a board. Its implementation is in tls_stream.h.
#pragma once

#include <memory>
#include <string>

namespace gicube {

class Tls;

// For a board at `host`, a name or a numeric address, which its certificate must have. The certificate must be signed
// by one of those in OpenOptions::ca_file or, if that is empty, in the file of GICUBE_CA_FILE or the system's. Throws
// BadArgument if there is no such file.
std::shared_ptr<Tls> make_tls(const std::string& host, const std::string& ca_file);

}  // namespace gicube
