#include "token.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <stdexcept>
#include <system_error>

namespace gicube::emu {

std::string read_token(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw std::runtime_error(fmt::format("{}: {}", path, std::generic_category().message(errno)));
  struct stat status {};
  const bool is_file = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
  const bool is_private = is_file && (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  std::array<char, 4096> bytes{};
  const ssize_t size = is_private ? ::read(fd, bytes.data(), bytes.size()) : 0;
  ::close(fd);
  if (!is_file) throw std::runtime_error(fmt::format("{}: expected a file with a token", path));
  if (!is_private) {
    throw std::runtime_error(fmt::format("{}: expected a file that only its owner can read (mode 600), got mode {:o}",
                                         path, status.st_mode & 0777u));
  }
  std::string token(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
  if (token.size() < kMinTokenBytes || token.size() >= bytes.size()) {
    throw std::runtime_error(fmt::format("{}: expected a token of {} to {} characters, got {}", path, kMinTokenBytes,
                                         bytes.size() - 1, token.size()));
  }
  return token;
}

bool is_authorized(std::string_view authorization, std::string_view token) {
  constexpr std::string_view kScheme = "Bearer ";
  if (!authorization.starts_with(kScheme)) return false;
  authorization.remove_prefix(kScheme.size());
  // Only the length, which is no secret, can end it early.
  if (authorization.size() != token.size()) return false;
  std::uint8_t difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i) {
    difference = static_cast<std::uint8_t>(difference | (static_cast<std::uint8_t>(authorization[i] ^ token[i])));
  }
  return difference == 0;
}

}  // namespace gicube::emu
