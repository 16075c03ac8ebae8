// TLS of the data plane on the board's side. The implementation is hidden in tls_stream.h.
#pragma once

#include <memory>
#include <string>

namespace gicube::emu {

class Tls;

// Loads the certificate and its private key from PEM files. Throws std::runtime_error with the name of the invalid
// file.
std::shared_ptr<Tls> make_tls(const std::string& certificate_file, const std::string& key_file);

}  // namespace gicube::emu
