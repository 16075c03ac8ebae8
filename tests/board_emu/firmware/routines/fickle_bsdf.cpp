#include "fickle_bsdf.h"

#include <signal.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "gicube/bsdf.h"

#ifndef BSDF_VERSION
#define BSDF_VERSION GICUBE_BSDF_ABI
#endif

namespace {

using gicube::emu::Whim;

Whim whim_of(const float* parameters, std::uint32_t count) {
  return count > 0 ? static_cast<Whim>(static_cast<int>(parameters[0])) : Whim::kRetroreflect;
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
    case Whim::kEndless:
      for (volatile bool waiting = true; waiting;) {
      }
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
    case Whim::kRefuse: break;
  }
}

int check(const float* parameters, std::uint32_t count, char* text, std::size_t text_bytes) {
  if (whim_of(parameters, count) != Whim::kRefuse) return 0;
  std::snprintf(text, text_bytes, "mood: expected good, got %g", static_cast<double>(parameters[0]));
  return 1;
}

constexpr gicube_bsdf kRoutine{
    BSDF_VERSION, sizeof(gicube_bsdf), "fickle", gicube::emu::kFickleCycles, gicube::emu::kFickleBudget, scatter,
    check};

}  // namespace

extern "C" const gicube_bsdf* gicube_bsdf_describe(void) { return &kRoutine; }
