// Records the sessions of session.h on the board and driver that it is built with (docs/contributing/release.md).
//
// Usage: record_sessions FOLDER
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include "session.h"

int main(int count, char** words) {
  if (count != 2) return 2;
  const std::string folder = std::string(words[1]) + '/';
  try {
    for (const auto& session : gicube::captures::sessions()) {
      const std::string uri = std::string("emu:") + gicube::captures::kOptions;
      gicube::OpenOptions options;
      options.capture = folder + session.name + ".cap";
      auto board = gicube::Board::open(uri, options);
      std::ofstream(folder + session.name + ".txt") << session.use(board);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "record_sessions: %s\n", error.what());
    return 1;
  }
}
