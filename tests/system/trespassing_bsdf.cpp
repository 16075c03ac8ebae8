// A scattering routine that tries what a board has no use for when its parameters are checked, and says what each came
// to.
#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>

#include "gicube/bsdf.h"

namespace {

int error_of(long result) { return result < 0 ? errno : 0; }

// With a parameter: starts a program.
int check(const float*, std::uint32_t count, char* text, std::size_t text_bytes) {
  if (count > 0) {
    const char* const words[] = {"true", nullptr};
    ::execv("/bin/true", const_cast<char* const*>(words));
  }
  const int read = error_of(::open("/etc/passwd", O_RDONLY | O_CLOEXEC));
  const int make = error_of(::open("/tmp/trespassing", O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  ::unlink("/tmp/trespassing");
  const int reach = error_of(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int signal = error_of(::kill(::getppid(), 0));
  std::snprintf(text, text_bytes, "read %d, make %d, reach %d, signal %d", read, make, reach, signal);
  return 1;
}

}  // namespace

extern "C" const gicube_bsdf* gicube_bsdf_describe() {
  static const gicube_bsdf kRoutine{GICUBE_BSDF_ABI,
                                    sizeof(gicube_bsdf),
                                    "trespassing",
                                    1,
                                    1,
                                    [](const gicube_bsdf_event*, gicube_bsdf_answer*) {},
                                    check};
  return &kRoutine;
}
