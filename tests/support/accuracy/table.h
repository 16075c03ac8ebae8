// The study's figures as CSV tables, those of docs/studies/accuracy.md.
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

std::string scene_table(const std::vector<Row>& rows);
// The effect of each quantiser by itself: PSNR in dB, and the largest error in brackets.
std::string quantiser_table(const std::vector<Row>& rows);

}  // namespace gicube::accuracy
