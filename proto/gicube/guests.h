// Pending connections of a server: new ones that have not stated a request yet (silent), and those queued for a board.
//
// A new connection is always accepted, so silent clients cannot lock out anyone, least of all an owner who reconnects.
// If no place is free, the oldest silent connection is closed. Therefore the queue may not fill all places.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace gicube {

// `Connection` has a host(), which identifies its peer. Not thread-safe.
template <typename Connection>
class Guests {
 public:
  using Connected = std::shared_ptr<Connection>;

  // The maximum number of connections in total and per peer; each is at least two.
  Guests(std::size_t places, std::size_t places_of_peer) : places_(places), places_of_peer_(places_of_peer) {}

  // Adds a silent connection. Returns the connection that must be closed for it, or null.
  Connected enter(Connected guest) {
    const std::string& host = guest->host();
    const std::string* crowd = nullptr;  // the host whose oldest silent connection is closed
    if (count(&host, false) + count(&host, true) >= places_of_peer_) {
      crowd = &host;
    } else if (guests_.size() >= places_) {
      std::size_t most = 0;
      for (const Guest& each : guests_) {
        const std::size_t silent = count(&each.connection->host(), false);
        if (silent <= most) continue;
        most = silent;
        crowd = &each.connection->host();
      }
    }
    Connected out;
    if (crowd != nullptr) {
      const auto oldest = std::ranges::find_if(
          guests_, [&](const Guest& each) { return !each.queued && each.connection->host() == *crowd; });
      out = oldest->connection;  // it exists: the queue leaves places free
      guests_.erase(oldest);
    }
    guests_.push_back({std::move(guest)});
    size_ = guests_.size();
    return out;
  }
  void leave(const Connected& guest) {
    std::erase_if(guests_, [&](const Guest& each) { return each.connection == guest; });
    size_ = guests_.size();
  }
  // Adds a connection that has requested a board to the queue. Returns an empty string, or the reason why the queue is
  // full. A connection stays in the queue while it owns the board.
  std::string enqueue(const Connected& guest) {
    const auto found = std::ranges::find(guests_, guest, &Guest::connection);
    if (found == guests_.end()) return "another connection has taken its place";
    if (found->queued) return {};
    const std::string& host = guest->host();
    if (count(&host, true) >= queue_share(places_of_peer_)) {
      return std::to_string(queue_share(places_of_peer_)) + " connections of " + host + " wait for a board already";
    }
    if (count(nullptr, true) >= queue_share(places_)) {
      return std::to_string(queue_share(places_)) + " connections wait for a board already";
    }
    found->queued = true;
    return {};
  }

  std::vector<Connected> all() const {
    std::vector<Connected> connections;
    for (const Guest& each : guests_) connections.push_back(each.connection);
    return connections;
  }
  std::size_t size() const { return size_; }  // thread-safe

 private:
  struct Guest {
    Connected connection;
    bool queued = false;
  };

  // The share of the places that the queue may take.
  static std::size_t queue_share(std::size_t places) {
    constexpr std::size_t kPartForOthers = 8;  // chosen: an eighth is enough for handshakes, which take milliseconds
    return places - std::max<std::size_t>(1, places / kPartForOthers);
  }
  // Counts connections of this host, or of all hosts if null.
  std::size_t count(const std::string* host, bool queued) const {
    return static_cast<std::size_t>(std::ranges::count_if(guests_, [&](const Guest& each) {
      return each.queued == queued && (host == nullptr || each.connection->host() == *host);
    }));
  }

  const std::size_t places_, places_of_peer_;
  std::vector<Guest> guests_;  // in order of arrival
  std::atomic<std::size_t> size_ = 0;
};

}  // namespace gicube
