// The connections of a bus server that own no board: who has yet to say its version, and who stands in line.
//
// A newcomer always finds a place, so that whoever is silent can keep nobody out, least of all a session's owner who comes back: if
// there is none left, the oldest silent connection makes way. For that the line never takes all places.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "connection.h"

namespace gicube::emu {

class Guests {
 public:
  using Connected = std::shared_ptr<Connection>;

  // Places in all and for one peer, each at least two.
  Guests(std::size_t places, std::size_t places_of_peer) : places_(places), places_of_peer_(places_of_peer) {}

  // One more, silent so far. Returns the one whose place it takes, or null.
  Connected enter(Connected guest);
  void leave(const Connected& guest) {
    std::erase_if(guests_, [&](const Guest& each) { return each.connection == guest; });
    size_ = guests_.size();
  }
  // It has said its version and wants a board. Returns why there is no room in the line; empty: it stands there.
  std::string stand_in_line(const Connected& guest);

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
  std::size_t count(const std::string* host, bool in_line) const;

  const std::size_t places_, places_of_peer_;
  std::vector<Guest> guests_;  // in the order of their coming
  std::atomic<std::size_t> size_ = 0;
};

}  // namespace gicube::emu
