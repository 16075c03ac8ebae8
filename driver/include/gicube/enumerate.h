// The boards that a program could open.
//
//   for (const gicube::FoundBoard& found : gicube::enumerate()) {
//     if (!found.in_use) return gicube::Board::open(found.uri);
//   }
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gicube/export.h"

namespace gicube {

struct FoundBoard {           // a board that a program could open
  std::string uri;            // for Board::open()
  std::uint32_t process = 0;  // the id of its gicube-board; 0: a PCI function, without version and owner
  std::string product;        // the board's product name
  std::string version;        // of its program
  bool in_use = false;        // a session owns it
  std::string owner;          // which, and since when; empty: none
};

// The boards on this machine that listen and are of this user, by process and index, then its PCI functions that are
// boards (pci:), by address. Private boards (emu:) of other programs are none. It opens no session. A process that does
// not answer within two seconds of wall-clock time is left out. Throws Error if the folder in which boards make
// themselves known can't be trusted.
GICUBE_API std::vector<FoundBoard> enumerate();

}  // namespace gicube
