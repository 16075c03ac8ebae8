// gicube-bsdf-host: the process in which a board has the code of one plug-in run (firmware/routines/plug_in_process.h starts it).
//
// It loads the library, and then makes a copy of itself for each call that goes on at a time: so what crashes or never returns is one
// call, a new process costs no new loading, and the file may change meanwhile. It and its copies have no descriptor of the board, and
// none of its memory but the calls.
#include <unistd.h>

#include <cstdio>
#include <cstring>

#include "firmware/routines/call_memory.h"
#include "library.h"
#include "rights.h"
#include "workers.h"

int main(int argc, char** argv) {
  using namespace gicube::emu;
  CallMemory* const memory = argc == 3 ? shared_memory() : nullptr;
  if (memory == nullptr) {
    std::fprintf(stderr, "gicube-bsdf-host: gicube-board --bsdf FILE starts this program; by itself it does nothing\n");
    return 2;
  }
  give_up_rights();
  end_with_parent(true);
  const gicube_bsdf* const routine = load(argv[1], memory->loading);
  end_with_parent(false);  // its thread may go; the socket says when the process does
  memory->loading.turn.give(Party::kBoard);
  if (routine != nullptr) serve_orders(*memory, *routine, std::strcmp(argv[2], kBoxedWord) == 0);
  ::_exit(0);  // no more code of the library
}
