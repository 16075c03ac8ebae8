#include "gicube/access.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <system_error>

#include "gicube/registry.h"

namespace gicube {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{64} << 10;  // chosen: about a hundred of the longest tokens
constexpr std::array<std::string_view, 3> kRightNames{"read", "use", "control"};  // indexed by Right

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

std::string reason(int error) { return std::generic_category().message(error); }

std::string read_private_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) fail(path, reason(errno));
  struct stat status {};
  const bool is_file = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
  const bool is_private = is_file && (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  std::string text(kMaxFileBytes + 1, '\0');
  const ssize_t size = is_private ? ::read(fd, text.data(), text.size()) : 0;
  ::close(fd);
  if (!is_file) fail(path, "expected a file with tokens");
  if (!is_private) {
    fail(path, "expected a file that only its owner can read (mode 600), got mode " + mode_text(status.st_mode));
  }
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  if (text.size() > kMaxFileBytes) {
    fail(path, "expected at most " + std::to_string(kMaxFileBytes) + " bytes of tokens, got more");
  }
  return text;
}

AccessToken token_of(const std::string& path, std::string_view line) {
  AccessToken token{Right::kControl, std::string(line)};
  if (const std::size_t space = line.find(' '); space != std::string_view::npos) {
    const auto* const right = std::ranges::find(kRightNames, line.substr(0, space));
    if (right == kRightNames.end()) fail(path, "expected read, use or control before a token, got something else");
    token = {static_cast<Right>(right - kRightNames.begin()), std::string(line.substr(space + 1))};
  }
  const std::size_t size = token.token.size();
  if (size < kMinTokenBytes || size > kMaxTokenBytes) {
    fail(path, "expected a token of " + std::to_string(kMinTokenBytes) + " to " + std::to_string(kMaxTokenBytes) +
                   " characters, got " + std::to_string(size));
  }
  for (const char c : token.token) {
    if (c <= ' ' || c > '~') fail(path, "expected printable characters without spaces in a token, got another one");
  }
  return token;
}

// The time depends only on the length, which is not secret.
bool equal(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned>(a[i] ^ b[i]);
  return difference == 0;
}

}  // namespace

const char* name_of(Right right) { return kRightNames[static_cast<std::size_t>(right)].data(); }

std::string new_token() {
  constexpr std::string_view kDigits = "0123456789abcdef";
  constexpr int kWords = 8;  // 32 bits each
  std::random_device random;
  std::string token;
  for (int i = 0; i < kWords; ++i) {
    unsigned word = random();
    for (int digit = 0; digit < 8; ++digit, word >>= 4) token += kDigits[word & 15];
  }
  return token;
}

std::vector<AccessToken> read_tokens(const std::string& path) {
  const std::string text = read_private_file(path);
  std::vector<AccessToken> tokens;
  std::string_view rest = text;
  while (!rest.empty()) {
    std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(line.size() < rest.size() ? line.size() + 1 : line.size());
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty()) tokens.push_back(token_of(path, line));
  }
  if (tokens.empty()) fail(path, "expected a token, got none");
  return tokens;
}

std::optional<Right> right_of(const std::vector<AccessToken>& tokens, std::string_view token) {
  std::optional<Right> right;
  for (const AccessToken& each : tokens) {
    if (equal(each.token, token)) right = each.right;
  }
  return right;
}

void write_token(const std::string& path, const std::string& token) {
  const std::string fresh = path + "." + std::to_string(::getpid());
  ::unlink(fresh.c_str());
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (fd < 0) fail(fresh, reason(errno));
  const std::string line = token + "\n";
  const bool written = ::write(fd, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const bool closed = ::close(fd) == 0;
  if (written && closed && std::rename(fresh.c_str(), path.c_str()) == 0) return;
  const int error = errno;
  ::unlink(fresh.c_str());
  fail(path, reason(error));
}

std::string token_file(const std::string& folder, const std::string& address, std::uint16_t port) {
  const bool is_v6 = address.find(':') != std::string::npos;
  return folder + '/' + (is_v6 ? "[" + address + "]" : address) + ':' + std::to_string(port) + ".token";
}

// If a process listens at an address, or at all addresses of a family, no other process can listen at the same port. So
// the token cannot reach a stranger.
std::string local_token(const std::string& address, std::uint16_t port) {
  const bool is_v4 = address.starts_with("127.");
  if (!is_v4 && address != "::1") return {};
  const std::string folder = registry_folder();
  if (!registry_fault(folder).empty()) return {};
  for (const std::string& bound : {address, std::string(is_v4 ? "0.0.0.0" : "::")}) {
    try {
      return read_tokens(token_file(folder, bound, port)).front().token;
    } catch (const std::runtime_error&) {  // the file does not exist or is not usable
    }
  }
  return {};
}

}  // namespace gicube
