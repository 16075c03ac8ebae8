// A Unix socket through which a client reaches a board, and which loses each connection after so many bytes.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <thread>

namespace gicube::system_test {

class CutLink {
 public:
  CutLink(const std::string& path, std::string board) : board_(std::move(board)) {
    const sockaddr_un address = address_of(path);
    listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener_, 8) != 0) {
      throw std::runtime_error("no socket at " + path);
    }
    thread_ = std::thread([this] { serve(); });
  }
  // After the client.
  ~CutLink() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  CutLink(const CutLink&) = delete;
  CutLink& operator=(const CutLink&) = delete;

  // In both directions together, of each connection from now on; 0: it is never cut.
  void cut_after(std::size_t bytes) {
    left_ = bytes;
    limit_ = bytes;
  }
  int cuts() const { return cuts_; }

 private:
  static sockaddr_un address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    return address;
  }

  void serve() {
    for (int client = 0; (client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
      const int board = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_un address = address_of(board_);
      left_ = limit_.load();
      if (::connect(board, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
        while (carry(client, board)) continue;
      }
      ::close(client);
      ::close(board);
    }
  }

  // What one side has sent, to the other. False once the connection has ended.
  bool carry(int client, int board) {
    std::array<pollfd, 2> ends{pollfd{client, POLLIN, 0}, pollfd{board, POLLIN, 0}};
    ::poll(ends.data(), ends.size(), -1);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].revents == 0) continue;
      std::array<char, 16'384> bytes{};
      const std::size_t most = limit_ == 0 ? bytes.size() : std::min(bytes.size(), left_.load());
      const ssize_t got = ::recv(ends[i].fd, bytes.data(), most, 0);
      if (got <= 0) return false;
      for (ssize_t sent = 0, now = 0; sent < got; sent += now) {
        now = ::send(ends[1 - i].fd, bytes.data() + sent, static_cast<std::size_t>(got - sent), MSG_NOSIGNAL);
        if (now <= 0) return false;
      }
      if (limit_ == 0) continue;
      left_ -= static_cast<std::size_t>(got);
      if (left_ > 0) continue;
      ++cuts_;
      return false;
    }
    return true;
  }

  const std::string board_;
  int listener_ = -1;
  std::atomic<std::size_t> limit_ = 0, left_ = 0;
  std::atomic<int> cuts_ = 0;
  std::thread thread_;  // last: it uses all of the others
};

}  // namespace gicube::system_test
