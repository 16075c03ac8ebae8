// TLS of the data plane, the board's end. What it is made of, only tls_stream.h knows.
#pragma once

#include <memory>
#include <string>

namespace gicube::emu {

class Tls;

// With this certificate and its private key, PEM files. Throws std::runtime_error that names the file that is no good.
std::shared_ptr<Tls> make_tls(const std::string& certificate_file, const std::string& key_file);

}  // namespace gicube::emu
