// gicube-plug-in-host: the process in which a board has the code of one plug-in run (plug_ins/plug_in_process.h starts
// it).
//
// It loads the library. For a routine it then makes a copy of itself for each call that goes on at a time: so what
// crashes or never returns is one call, a new process costs no new loading, and the file may change meanwhile. It and
// its copies have none of the board's memory but the calls. An observer's events it takes itself.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>

#include "box/box.h"
#include "host.h"

int main(int argc, char** argv) {
  using namespace gicube::emu;
  CallMemory* const memory = argc == 4 ? shared_memory() : nullptr;
  if (memory == nullptr) {
    std::fprintf(
        stderr,
        "gicube-plug-in-host: gicube-board --bsdf FILE or --observer FILE starts this program; by itself it does "
        "nothing\n");
    return 2;
  }
  const bool is_observer = std::strcmp(argv[2], kObserverWord) == 0, is_boxed = std::strcmp(argv[3], kBoxedWord) == 0;
  give_up_rights(is_observer);
  end_with_parent(true);
  const gicube_bsdf* const routine = is_observer ? nullptr : load_routine(argv[1], memory->loading);
  const gicube_observer* const observer = is_observer ? load_observer(argv[1], memory->loading) : nullptr;
  end_with_parent(false);  // its thread may go; the socket says when the process does
  if (observer != nullptr && is_boxed) enter_box({.has_clients = false});
  memory->loading.turn.give(Party::kBoard);
  if (observer != nullptr) {
    ::munmap(memory, sizeof *memory);
    return serve_events(*observer, argv[1]);
  }
  if (routine != nullptr) serve_orders(*memory, *routine, is_boxed);
  ::_exit(0);  // no more code of the library
}
