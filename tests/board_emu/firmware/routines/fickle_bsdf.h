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
  kSleep,
  kStuck,  // and takes no signals: it never ends
  kThrow,
  kRefuse,  // by its check of parameters
};

inline constexpr unsigned kFickleCycles = 150, kFickleBudget = 1000;

}  // namespace gicube::emu
