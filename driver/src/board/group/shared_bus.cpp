#include "shared_bus.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gicube {
namespace {

struct PhasesLeft {
  std::size_t board = 0;
  std::span<const BusPhase> left;  // the phases left; the first is under way
  double time_left = 0;            // of that one, ps, with the bus alone
  double speed = 1;

  double share() const {  // of the bus that the phase asks for
    return static_cast<double>(left.front().busy) / static_cast<double>(left.front().elapsed);
  }
  double until_next() const { return time_left / speed; }
  // Begins the next phase. False: none is left.
  bool begin() {
    while (!left.empty() && left.front().elapsed == 0) left = left.subspan(1);
    if (!left.empty()) time_left = static_cast<double>(left.front().elapsed);
    return !left.empty();
  }
};

// Boards that ask for less than an equal share get it; the others share the rest equally.
void divide_bus(std::vector<PhasesLeft>& courses) {
  std::ranges::stable_sort(courses, {}, &PhasesLeft::share);
  double rest = 1;
  for (std::size_t i = 0; i < courses.size(); ++i) {
    const double fair = rest / static_cast<double>(courses.size() - i), asked = courses[i].share();
    courses[i].speed = asked > fair ? fair / asked : 1;
    rest -= std::min(asked, fair);
  }
}

}  // namespace

std::vector<Picoseconds> done_on_shared_bus(std::span<const std::vector<BusPhase>> boards) {
  constexpr double kRounding = 1e-12;  // chosen: share of a phase, so that phases that end together do so in one step
  std::vector<Picoseconds> done(boards.size());
  std::vector<PhasesLeft> courses;
  for (std::size_t board = 0; board < boards.size(); ++board) {
    PhasesLeft course{.board = board, .left = boards[board]};
    if (course.begin()) courses.push_back(course);
  }
  double now = 0;
  while (!courses.empty()) {
    divide_bus(courses);
    double step = std::numeric_limits<double>::infinity();
    for (const PhasesLeft& course : courses) step = std::min(step, course.until_next());
    now += step;
    std::erase_if(courses, [&](PhasesLeft& course) {
      course.time_left -= step * course.speed;
      if (course.time_left > kRounding * static_cast<double>(course.left.front().elapsed)) return false;
      course.left = course.left.subspan(1);
      if (course.begin()) return false;
      done[course.board] = static_cast<Picoseconds>(std::llround(now));
      return true;
    });
  }
  return done;
}

}  // namespace gicube
