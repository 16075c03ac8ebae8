// Access tokens for boards that are reached over TCP, and the files that hold them. Only its owner may access a token
// file.
//
// A board process creates a new token at each start and stores it in its user's registry (registry.h), in a file named
// after the endpoint's address and port. Only programs of the same user on the same machine can read it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gicube {

// Each right includes the previous ones. kRead: inspect boards. kUse: open a board. kControl: take a board by force,
// reset it, configure it, set its fault plan, write traces.
enum class Right { kRead, kUse, kControl };
const char* name_of(Right right);

struct AccessToken {
  Right right{};
  std::string token;
};

inline constexpr std::size_t kMinTokenBytes =
    16;  // chosen: at least 64 bits if the characters are random hexadecimal digits
inline constexpr std::size_t kMaxTokenBytes = 512;  // chosen: fits into a handshake together with the version

// Returns 256 random bits as hexadecimal digits.
std::string new_token();

// Reads one token per line: "TOKEN" (right kControl), or "read TOKEN", "use TOKEN", "control TOKEN". Throws
// std::runtime_error with the file's name if the file cannot be read, if other users can access it, if it has no token
// or if a line is not valid.
std::vector<AccessToken> read_tokens(const std::string& path);
// Returns the right of this token, or nothing if it is not in the list. The time depends only on the token's length.
std::optional<Right> right_of(const std::vector<AccessToken>& tokens, std::string_view token);

// Creates or replaces the file with mode 600. Throws std::runtime_error.
void write_token(const std::string& path, const std::string& token);
// Path of the token file in a registry folder for an endpoint with this numeric address and port.
std::string token_file(const std::string& folder, const std::string& address, std::uint16_t port);
// Returns the token that a board process of this user has stored for this address and port, or an empty string. It is
// always empty for addresses of other machines, so that no token of this machine is sent to them.
std::string local_token(const std::string& address, std::uint16_t port);

}  // namespace gicube
