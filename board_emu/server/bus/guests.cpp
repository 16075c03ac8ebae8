#include "guests.h"

#include <fmt/format.h>

namespace gicube::emu {

// Of this host, or of all.
std::size_t Guests::count(const std::string* host, bool in_line) const {
  return static_cast<std::size_t>(std::ranges::count_if(guests_, [&](const Guest& each) {
    return each.in_line == in_line && (host == nullptr || each.connection->host() == *host);
  }));
}

Guests::Connected Guests::enter(Connected guest) {
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

std::string Guests::stand_in_line(const Connected& guest) {
  const auto found = std::ranges::find(guests_, guest, &Guest::connection);
  if (found == guests_.end()) return "another connection has taken its place";
  const std::string& host = guest->host();
  if (count(&host, true) >= line_of(places_of_peer_)) {
    return fmt::format("{} connections of {} wait for a board already", line_of(places_of_peer_), host);
  }
  if (count(nullptr, true) >= line_of(places_)) {
    return fmt::format("{} connections wait for a board already", line_of(places_));
  }
  found->in_line = true;
  return {};
}

}  // namespace gicube::emu
