// TLS of the data plane on the board's side. The headers of the implementation are heavy, so they are included only by
// the sources that need them.
#pragma once

#include <memory>
#include <string>

namespace boost::asio::ssl {
class context;
}

namespace gicube::emu {

using Tls = boost::asio::ssl::context;

// Loads the certificate and its private key from PEM files. Throws std::runtime_error with the name of the invalid
// file.
std::shared_ptr<Tls> make_tls(const std::string& certificate_file, const std::string& key_file);

}  // namespace gicube::emu
