// Who may do what with a board that is reached over TCP: tokens, and the files that hold them. Files of tokens are their owner's alone.
//
// A board process makes a token of its own, new each time, and leaves it in its user's registry (registry.h), by the endpoint's
// address and port. So a program of the same user on the same machine finds it, and nobody else does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gicube {

// Each includes those before it. kRead: look at boards. kUse: open one. kControl: take one by force, reset it, configure it, set its
// faults, have traces written.
enum class Right { kRead, kUse, kControl };
const char* name_of(Right right);

struct AccessToken {
  Right right{};
  std::string token;
};

inline constexpr std::size_t kMinTokenBytes = 16;   // chosen: 64 bits and more, if its digits are random
inline constexpr std::size_t kMaxTokenBytes = 512;  // chosen: with the version it fits into a handshake

// 256 random bits, as hexadecimal digits.
std::string new_token();

// One line each: "TOKEN", which may control, or "read TOKEN", "use TOKEN", "control TOKEN". Throws std::runtime_error that names the
// file: it can't be read, others than its owner can, it has no token or a line that is none.
std::vector<AccessToken> read_tokens(const std::string& path);
// What the holder of this token may do; nothing if it is none of these. Takes the same time for all tokens of a length.
std::optional<Right> right_of(const std::vector<AccessToken>& tokens, std::string_view token);

// Creates the file, mode 600, in place of what was there. Throws std::runtime_error.
void write_token(const std::string& path, const std::string& token);
// The file in a registry's folder for an endpoint with this numeric address, and port.
std::string token_file(const std::string& folder, const std::string& address, std::uint16_t port);
// The token that this user's board process has left for clients that have connected to this address and port; empty: there is none.
// None for addresses of other machines: they are to see no token of this one.
std::string local_token(const std::string& address, std::uint16_t port);

}  // namespace gicube
