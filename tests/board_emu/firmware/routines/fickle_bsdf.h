// What the test's routine does is its first parameter's to say.
#pragma once

namespace gicube::emu {

enum class Whim {
  kRetroreflect,  // and passes the share parameters[1], if there is one
  kNan,
  kInfinite,
  kZero,
  kPassesMore,
  kPassesLess,
  kPassesNan,
  kCostly,  // parameters[1] cycles
  kEndless,
  kSlow,  // takes parameters[1] seconds of processor time
  kSleep,
  kStuck,  // and takes no signals: it never ends
  kThrow,
  kSegfault,
  kAbort,
  kExit,  // with the code parameters[1]
  kKillParent,
  kReadBoard,   // the memory of the process that began its parent; throws if it can
  kLookAround,  // throws if it has a variable of the environment or a descriptor that it should not have
  kTell,        // number parameters[1] of the event, as direction[0]
  kRefuse,      // by its check of parameters
};

inline constexpr unsigned kFickleCycles = 150, kFickleBudget = 1000;

}  // namespace gicube::emu
