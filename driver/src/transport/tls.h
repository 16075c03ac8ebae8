// TLS of a connection to a board, the client's end. What it is made of, only tls_stream.h knows.
#pragma once

#include <memory>
#include <string>

namespace gicube {

class Tls;

// For a board at `host`, a name or a numeric address, which its certificate must have. The certificate must be signed
// by one of OpenOptions::ca_file, or what stands for it. Throws BadArgument: no such file.
std::shared_ptr<Tls> make_tls(const std::string& host, const std::string& ca_file);

}  // namespace gicube
