// A Unix socket through which a client reaches a board, and which loses each connection after so many bytes.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <thread>

#include "unix_socket.h"

namespace gicube::system_test {

class CutLink {
 public:
  CutLink(const std::string& path, std::string board)
      : board_(std::move(board)), listener_(reference::bound_socket(path)) {
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
  void serve() {
    for (int client = 0; (client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)) >= 0;) {
      const int board = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_un address = reference::unix_address(board_);
      left_ = limit_.load();
      if (::connect(board, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
        while (carry(client, board)) continue;
      }
      ::close(client);
      ::close(board);
    }
  }

  // Passes the bytes of one side to the other. False once the connection has ended.
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
  const int listener_;
  std::atomic<std::size_t> limit_ = 0, left_ = 0;
  std::atomic<int> cuts_ = 0;
  std::thread thread_;  // last: it uses all of the others
};

}  // namespace gicube::system_test
