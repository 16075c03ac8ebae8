// The study's figures as Markdown: what docs/studies/accuracy.md shows.
#pragma once

#include <string>
#include <vector>

#include "measure.h"

namespace gicube::accuracy {

struct Row {
  std::string scene;
  std::string look;
  Figures figures;
};

std::string markdown(const std::vector<Row>& rows);

}  // namespace gicube::accuracy
