#include "fickle_bsdf.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

#include "gicube/bsdf.h"

#ifndef BSDF_VERSION
#define BSDF_VERSION GICUBE_BSDF_ABI
#endif

namespace {

using gicube::emu::Whim;

Whim whim_of(const float* parameters, std::uint32_t count) {
  return count > 0 ? static_cast<Whim>(static_cast<int>(parameters[0])) : Whim::kRetroreflect;
}

void wait_for_ever() {
  for (volatile bool waiting = true; waiting;) {
  }
}

// Of the process that `process` was begun by; 0 where /proc can't be read, as in a box.
int parent_of(int process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string number, name, state;
  int parent = 0;
  file >> number >> name >> state >> parent;
  return file ? parent : 0;
}

// A sanitizer would report it and exit.
void segfault() {
  ::signal(SIGSEGV, SIG_DFL);
  void* const page = ::mmap(nullptr, 4096, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  *static_cast<volatile char*>(page) = 1;
}

void look_around() {
  if (::getenv("GICUBE_TOKEN_FILE") != nullptr) throw std::runtime_error("it has a variable");
  for (int fd = STDERR_FILENO + 1; fd < 1024; ++fd) {
    if (::fcntl(fd, F_GETFD) >= 0) throw std::runtime_error("it has descriptor " + std::to_string(fd));
  }
}

double told(const gicube_bsdf_event& event) {
  const std::array<double, 22> numbers{event.position[0],
                                       event.position[1],
                                       event.position[2],
                                       event.direction[0],
                                       event.direction[1],
                                       event.direction[2],
                                       event.normal[0],
                                       event.normal[1],
                                       event.normal[2],
                                       event.random[0],
                                       event.random[1],
                                       event.random[2],
                                       event.random[3],
                                       event.opacity,
                                       event.density,
                                       double(event.tag),
                                       double(event.lighting),
                                       double(event.generation),
                                       double(event.parameter_count),
                                       double(event.size),
                                       double(event.reserved),
                                       event.parameters[event.parameter_count - 1]};
  return numbers.at(static_cast<std::size_t>(event.parameters[1]));
}

void scatter(const gicube_bsdf_event* event, gicube_bsdf_answer* answer) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 3; ++i) answer->direction[i] = -event->direction[i];
  const float second = event->parameter_count > 1 ? event->parameters[1] : 1;
  switch (whim_of(event->parameters, event->parameter_count)) {
    case Whim::kRetroreflect: answer->passes = second; break;
    case Whim::kNan: answer->direction[1] = kNan; break;
    case Whim::kInfinite: answer->direction[2] = HUGE_VAL; break;
    case Whim::kZero: answer->direction[0] = answer->direction[1] = answer->direction[2] = 0; break;
    case Whim::kPassesMore: answer->passes = 1.5; break;
    case Whim::kPassesLess: answer->passes = -0.25; break;
    case Whim::kPassesNan: answer->passes = kNan; break;
    case Whim::kCostly: answer->cycles = static_cast<std::uint32_t>(second); break;
    case Whim::kEndless: wait_for_ever(); break;
    case Whim::kSlow:
      for (const std::clock_t begin = std::clock(); static_cast<float>(std::clock() - begin) < second * 1e6f;) continue;
      break;
    case Whim::kSleep:
      for (volatile bool waiting = true; waiting;) ::pause();
      break;
    case Whim::kStuck:
      sigset_t all;
      sigfillset(&all);
      ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
      for (volatile bool waiting = true; waiting;) ::pause();
      break;
    case Whim::kThrow: throw std::runtime_error("no mood");
    case Whim::kSegfault: segfault(); break;
    case Whim::kAbort: ::signal(SIGABRT, SIG_DFL); std::abort();
    case Whim::kExit: std::exit(static_cast<int>(second));
    case Whim::kKillParent:
      ::kill(::getppid(), SIGKILL);
      for (volatile bool waiting = true; waiting;) ::pause();
      break;
    case Whim::kReadBoard: {
      const int board = parent_of(::getppid());
      if (board != 0 && ::open(("/proc/" + std::to_string(board) + "/mem").c_str(), O_RDWR) >= 0) {
        throw std::runtime_error("it is open");
      }
      break;
    }
    case Whim::kLookAround: look_around(); break;
    case Whim::kTell: answer->direction[0] = told(*event); break;
    case Whim::kRefuse: break;
  }
}

int check(const float* parameters, std::uint32_t count, char* text, std::size_t text_bytes) {
  if (whim_of(parameters, count) != Whim::kRefuse) return 0;
  std::snprintf(text, text_bytes, "mood: expected good, got %g", static_cast<double>(parameters[0]));
  return 1;
}

#ifdef BSDF_AT_START
[[maybe_unused]] const int kAtStart = (BSDF_AT_START, 0);
#endif

constexpr gicube_bsdf kRoutine{
    BSDF_VERSION, sizeof(gicube_bsdf), "fickle", gicube::emu::kFickleCycles, gicube::emu::kFickleBudget, scatter,
    check};

}  // namespace

extern "C" const gicube_bsdf* gicube_bsdf_describe(void) { return &kRoutine; }
