// What a sweep found: one row a point, which of them are on the Pareto front, and the files for others.
#pragma once

#include <string>
#include <vector>

#include "sweep/parameter.h"

namespace gicube::samples::sweep {

struct Row {
  Point point;
  double cost = 0;
  double error = 0;
  std::vector<double> also;  // further figures; NaN: the run does not have it
  bool is_reference = false;
  bool on_front = false;
  std::string command;
};

struct Table {
  std::string cost, error;        // names of the axes
  std::vector<std::string> also;  // names of further figures
  std::vector<Row> rows;
};

// Marks the Pareto front: rows that no other row beats in cost or error without losing in the other. References have no error,
// and stay out.
void mark_front(std::vector<Row>& rows);

// How much the cost changes with the setting `name`: the largest relative difference between rows that have all other settings in common.
double cost_change(const Table& table, const std::string& name);

// One line for each row, a column for each setting; the command last.
std::string csv(const Table& table);
// The same, and the front by itself.
std::string json(const Table& table);
// A gnuplot script that draws NAME.csv beside it as NAME.svg.
std::string chart(const Table& table, const std::string& name, const std::string& title);

}  // namespace gicube::samples::sweep
