// The results of the suite, as text and as JUnit XML.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "case.h"

namespace gicube::conformance {

struct Outcome {
  Case tested;
  std::string failure;  // empty: passed
  double seconds = 0;   // wall clock
};

// The lines that are printed when a case ends.
std::string line_of(const Outcome& outcome);
// Passed cases of each class, and the classes that the board may claim: those of which all cases, and all cases of
// class 0, were run and passed.
std::string summary(std::span<const Outcome> outcomes);
std::string junit(std::span<const Outcome> outcomes, const std::string& uri);
// The cases, with their rules.
std::string listed(std::span<const Case> cases);

}  // namespace gicube::conformance
