#include "sweep/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

namespace gicube::samples::sweep {
namespace {

// Names of all settings, in the order in which they first come.
std::vector<std::string> setting_names(const Table& table) {
  std::vector<std::string> names;
  for (const Row& row : table.rows) {
    for (const Setting& setting : row.point) {
      if (std::ranges::count(names, setting.name) == 0) names.push_back(setting.name);
    }
  }
  return names;
}

std::string value_of(const Point& point, const std::string& name) {
  const auto found = std::ranges::find(point, name, &Setting::name);
  return found != point.end() ? found->value : "";
}

// In quotes if it has commas, quotes or line ends (RFC 4180).
std::string csv_cell(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

nlohmann::ordered_json to_json(const Table& table, const Row& row) {
  nlohmann::ordered_json out;
  for (const Setting& setting : row.point) out["settings"][setting.name] = setting.value;
  out[table.cost] = row.cost;
  out["error " + table.error] = row.is_reference ? nlohmann::ordered_json() : nlohmann::ordered_json(row.error);
  for (std::size_t i = 0; i < table.also.size(); ++i) out[table.also[i]] = row.also[i];  // null if there is none
  out["reference"] = row.is_reference;
  out["front"] = row.on_front;
  out["command"] = row.command;
  return out;
}

}  // namespace

void mark_front(std::vector<Row>& rows) {
  for (Row& row : rows) {
    row.on_front = !row.is_reference && std::none_of(rows.begin(), rows.end(), [&](const Row& other) {
      return !other.is_reference && other.cost <= row.cost && other.error <= row.error &&
             (other.cost < row.cost || other.error < row.error);
    });
  }
}

double cost_change(const Table& table, const std::string& name) {
  struct Range {
    double low, high;
  };
  std::map<std::string, Range> ranges;  // by the other settings
  for (const Row& row : table.rows) {
    std::string others;
    for (const Setting& setting : row.point) {
      if (setting.name != name) others += setting.name + '=' + setting.value + '\n';
    }
    Range& range = ranges.try_emplace(others, row.cost, row.cost).first->second;
    range = {std::min(range.low, row.cost), std::max(range.high, row.cost)};
  }
  double change = 0;
  for (const auto& [others, range] : ranges) {
    if (range.low > 0) change = std::max(change, range.high / range.low - 1);
  }
  return change;
}

std::string csv(const Table& table) {
  const std::vector<std::string> names = setting_names(table);
  std::string text = fmt::format("{},{},front,reference", csv_cell(table.cost), csv_cell("error " + table.error));
  for (const std::string& name : table.also) text.append(1, ',').append(csv_cell(name));
  for (const std::string& name : names) text.append(1, ',').append(csv_cell(name));
  text += ",command\n";
  for (const Row& row : table.rows) {
    text += fmt::format("{:.6g},{},{:d},{:d}", row.cost, row.is_reference ? "" : fmt::format("{:.6g}", row.error),
                        row.on_front, row.is_reference);
    for (const double figure : row.also) text += std::isnan(figure) ? "," : fmt::format(",{:.6g}", figure);
    for (const std::string& name : names) text.append(1, ',').append(csv_cell(value_of(row.point, name)));
    text += fmt::format(",{}\n", csv_cell(row.command));
  }
  return text;
}

std::string json(const Table& table) {
  nlohmann::ordered_json out;
  out["cost"] = table.cost;
  out["error"] = table.error;
  out["points"] = out["front"] = nlohmann::ordered_json::array();
  for (const Row& row : table.rows) {
    out["points"].push_back(to_json(table, row));
    if (row.on_front) out["front"].push_back(to_json(table, row));
  }
  return out.dump(2) + "\n";
}

std::string chart(const Table& table, const std::string& name, const std::string& title) {
  return fmt::format(R"(# Drawn by gicube-sweep: all points, and the Pareto front as a line.
set datafile separator ','
set title "{0}" noenhanced
set xlabel "{1}" noenhanced
set ylabel "error: {2}" noenhanced
set logscale xy
set grid
set key top right
set terminal svg size 800,520 background 'white'
if (!exists("picture")) picture = '{3}.svg'
set output picture
plot '{3}.csv' skip 1 using 1:($2 > 0 ? $2 : NaN) with points pt 7 ps 0.6 lc rgb "gray50" title "runs", \
  "< awk -F, 'NR > 1 && $3 == 1 && $2 > 0' {3}.csv | sort -t, -g -k1,1" using 1:2 with linespoints pt 7 lw 2 \
  lc rgb "#c04000" title "Pareto front"
)",
                     title, table.cost, table.error, name);
}

}  // namespace gicube::samples::sweep
