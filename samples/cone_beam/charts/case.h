// One reconstruction of a chart: what is scanned, how, by which method on which board; what comes out and what it costs.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "cone_beam/algebraic.h"
#include "cone_beam/fdk.h"
#include "cone_beam/phantom/comparison.h"
#include "cone_beam/phantom/phantom.h"
#include "scene/program/board_options.h"

namespace gicube::samples {

struct Case {
  Phantom phantom;
  ConeGeometry geometry;
  std::variant<FdkSettings, AlgebraicSettings> method;
  FieldOfView field;
  double photons = 0;                      // a pixel; 0: no noise
  std::vector<std::string> settings = {};  // of the board
};

struct Outcome {
  Reconstruction made;
  Comparison error;
  // Simulated: the time of the functional level, which is that of DSP and bus, and for each view what its rays take longer than
  // that at the cycle level: the mean of two views, or of an iterative method of a second pass through two.
  double board_ms = 0;
  double bus_ms = 0;  // in which the bus is busy, both directions
};

class Runner {
 public:
  explicit Runner(BoardOptions board) : board_(std::move(board)) {}

  Outcome run(const Case& what);
  Reconstruction reconstruct(const Case& what);  // alone, without what it costs
  // An emulated board as a point needs it, with room for its volume.
  Board open(const std::string& fidelity, const std::vector<std::string>& settings) const;

 private:
  double rays_over_bus_ms(const Case& what);

  BoardOptions board_;
  std::map<std::string, double> known_;  // of rays_over_bus_ms(), which many points share
};

}  // namespace gicube::samples
