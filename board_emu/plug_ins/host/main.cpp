// gicube-plug-in-host: the process that runs the code of one plug-in for a board (plug_ins/plug_in_process.h starts
// it).
//
// It loads the library. For a routine it then forks a process for each concurrent call. So a crash or an endless loop
// affects one call, a new process need not load the library again, and the file may change meanwhile. These processes
// share only the memory of the calls with the board. For an observer, it processes the events itself.
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
        "gicube-plug-in-host: expected to be started by gicube-board with --bsdf FILE or --observer FILE, got started "
        "directly\n");
    return 2;
  }
  const bool is_observer = std::strcmp(argv[2], kObserverWord) == 0, is_boxed = std::strcmp(argv[3], kBoxedWord) == 0;
  give_up_rights(is_observer);
  end_with_parent(true);
  const gicube_bsdf* const routine = is_observer ? nullptr : load_routine(argv[1], memory->loading);
  const gicube_observer* const observer = is_observer ? load_observer(argv[1], memory->loading) : nullptr;
  end_with_parent(false);  // that thread may end; the socket shows when the board process has ended
  if (observer != nullptr && is_boxed) enter_box({.has_clients = false});
  memory->loading.turn.give(Party::kBoard);
  if (observer != nullptr) {
    ::munmap(memory, sizeof *memory);
    return serve_events(*observer, argv[1]);
  }
  if (routine != nullptr) serve_orders(*memory, *routine, is_boxed);
  ::_exit(0);  // without running further code of the library
}
