// The suite's results, as text and as JUnit's XML.
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

// A line for a case as it ends.
std::string line_of(const Outcome& outcome);
// Passed cases of each class, and the classes that a board with these outcomes may claim: all cases of the class and of
// class 0 were run and passed.
std::string summary(std::span<const Outcome> outcomes);
std::string junit(std::span<const Outcome> outcomes, const std::string& uri);
// The list of cases with their rules and sentences.
std::string listed(std::span<const Case> cases);

}  // namespace gicube::conformance
