// The connections of a server that it owes nothing yet: who has yet to say what it wants, and who waits for it.
//
// A newcomer always finds a place, so that whoever is silent can keep nobody out, least of all an owner who comes back:
// if there is none left, the oldest silent connection makes way. For that the line never takes all places.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace gicube {

// `Connection` has a host(), by which its peers are told apart. Not locked.
template <typename Connection>
class Guests {
 public:
  using Connected = std::shared_ptr<Connection>;

  // Places in all and for one peer, each at least two.
  Guests(std::size_t places, std::size_t places_of_peer) : places_(places), places_of_peer_(places_of_peer) {}

  // One more, silent so far. Returns the one whose place it takes, or null.
  Connected enter(Connected guest) {
    const std::string& host = guest->host();
    const std::string* crowd = nullptr;  // whose oldest silent connection makes way
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
          guests_, [&](const Guest& each) { return !each.in_line && each.connection->host() == *crowd; });
      out = oldest->connection;  // there is one: the line leaves places
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
  // It has said what it wants, as a board, and waits for it or has it. Returns why there is no room in the line; empty:
  // it stands there.
  std::string stand_in_line(const Connected& guest) {
    const auto found = std::ranges::find(guests_, guest, &Guest::connection);
    if (found == guests_.end()) return "another connection has taken its place";
    if (found->in_line) return {};
    const std::string& host = guest->host();
    if (count(&host, true) >= line_of(places_of_peer_)) {
      return std::to_string(line_of(places_of_peer_)) + " connections of " + host + " wait for a board already";
    }
    if (count(nullptr, true) >= line_of(places_)) {
      return std::to_string(line_of(places_)) + " connections wait for a board already";
    }
    found->in_line = true;
    return {};
  }

  std::vector<Connected> all() const {
    std::vector<Connected> connections;
    for (const Guest& each : guests_) connections.push_back(each.connection);
    return connections;
  }
  std::size_t size() const { return size_; }  // any thread

 private:
  struct Guest {
    Connected connection;
    bool in_line = false;
  };

  // How many of so many places the line may take.
  static std::size_t line_of(std::size_t places) {
    constexpr std::size_t kPartForOthers = 8;  // chosen: an eighth is enough for handshakes, which take milliseconds
    return places - std::max<std::size_t>(1, places / kPartForOthers);
  }
  // Of this host, or of all.
  std::size_t count(const std::string* host, bool in_line) const {
    return static_cast<std::size_t>(std::ranges::count_if(guests_, [&](const Guest& each) {
      return each.in_line == in_line && (host == nullptr || each.connection->host() == *host);
    }));
  }

  const std::size_t places_, places_of_peer_;
  std::vector<Guest> guests_;  // in the order of their coming
  std::atomic<std::size_t> size_ = 0;
};

}  // namespace gicube
