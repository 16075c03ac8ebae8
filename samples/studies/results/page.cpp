#include "studies/results/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scene/text_file.h"

namespace gicube::samples::results {
namespace {

constexpr double kTolerance = 0.25;  // beyond it a difference needs a reason
constexpr const char* kFolder = "results";

std::string joined(const std::vector<std::string>& cells, const std::string& between) {
  std::string text;
  for (std::size_t i = 0; i < cells.size(); ++i) text += (i == 0 ? "" : between) + cells[i];
  return text;
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::vector<std::string> quoted;
  for (const std::string& cell : cells) quoted.push_back(csv_cell(cell));
  return joined(quoted, ",") + '\n';
}

Table claims_table(const std::vector<Claim>& claims) {
  Table table{"claims", {"row", "claim (paper's section)", "paper", "ours", "within a quarter"}, {}};
  for (const Claim& claim : claims) {
    table.rows.push_back(
        {std::to_string(claim.number), claim.claim, claim.paper, claim.ours, claim.differs ? "no" : "yes"});
  }
  return table;
}

}  // namespace

bool differs(double ours, double low, double high) {
  return ours < (1 - kTolerance) * low || ours > (1 + kTolerance) * high;
}

std::string number(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }
std::string percent(double share, int digits) { return fmt::format("{:.{}f}%", 100 * share, digits); }

std::string to_markdown(const Table& table) {
  std::string text = "| " + joined(table.columns, " | ") + " |\n|";
  for (std::size_t i = 0; i < table.columns.size(); ++i) text += " --- |";
  text += '\n';
  for (const auto& row : table.rows) text += "| " + joined(row, " | ") + " |\n";
  return text;
}

std::string to_csv(const Table& table) {
  std::string text = csv_line(table.columns);
  for (const auto& row : table.rows) text += csv_line(row);
  return text;
}

std::string to_csv(const Chart& chart) {
  std::vector<std::string> names{chart.x_label};
  names.insert(names.end(), chart.series.begin(), chart.series.end());
  std::string text = csv_line(names);
  for (const auto& [x, values] : chart.points) {
    text += fmt::format("{:g}", x);
    for (const double value : values) text += std::isnan(value) ? "," : fmt::format(",{:.6g}", value);
    text += '\n';
  }
  return text;
}

std::string to_gnuplot(const Chart& chart) {
  std::string text = "set datafile separator ','\nset datafile missing ''\n";
  text += fmt::format("set title \"{}\"\nset xlabel \"{}\"\nset ylabel \"{}\"\n", chart.title, chart.x_label,
                      chart.y_label);
  text += "set grid\nset key above\n";
  if (chart.log_x) text += "set logscale x 2\n";
  if (chart.log_y) text += "set logscale y\n";
  if (chart.bars) text += "set style data histograms\nset style fill solid 0.8\nset yrange [0:*]\n";
  std::string plots;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const std::string columns =
        chart.bars ? fmt::format("{}:xtic(1)", i + 2) : fmt::format("1:{} with linespoints", i + 2);
    plots +=
        fmt::format("{}'{}.csv' using {} title \"{}\" lw 2", i == 0 ? "" : ", ", chart.name, columns, chart.series[i]);
  }
  return text + fmt::format("set terminal svg size 800,480 background 'white'\nset output '{}.svg'\nplot {}\n",
                            chart.name, plots);
}

void Page::heading(const std::string& text) { body_ += fmt::format("## {}\n\n", text); }
void Page::text(const std::string& text) { body_ += text + "\n\n"; }

void Page::table(const Table& table) {
  tables_.push_back(table);
  body_ += to_markdown(table) + fmt::format("\n[{0}/{1}.csv]({0}/{1}.csv)\n\n", kFolder, table.name);
}

void Page::chart(const Chart& chart, const std::string& caption) {
  charts_.push_back(chart);
  body_ += fmt::format("![{0}]({1}/{2}.svg)\n\n{3} [{1}/{2}.csv]({1}/{2}.csv)\n\n", chart.title, kFolder, chart.name,
                       caption);
}

void Page::picture(const std::string& file, const std::string& caption) {
  body_ += fmt::format("![{0}]({1}/{2})\n\n", caption, kFolder, file);
}

void Page::claim(const Claim& claim) {
  if (claim.differs && claim.why.empty()) {
    throw std::logic_error(
        fmt::format("row {} ({}): differs by more than a quarter and does not say why", claim.number, claim.claim));
  }
  claims_.push_back(claim);
}

std::string Page::claims() const {
  std::vector<Claim> sorted = claims_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Claim& a, const Claim& b) { return a.number < b.number; });
  std::string text = to_markdown(claims_table(sorted)) + fmt::format("\n[{0}/claims.csv]({0}/claims.csv)\n\n", kFolder);
  text += "Differences of more than a quarter:\n\n";
  for (const Claim& claim : sorted) {
    if (claim.differs) text += fmt::format("- **{}, {}**: {}\n", claim.number, claim.claim, claim.why);
  }
  return text + '\n';
}

void Page::write_files(const std::filesystem::path& folder) const {
  std::vector<Claim> sorted = claims_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Claim& a, const Claim& b) { return a.number < b.number; });
  write_text(folder / "claims.csv", to_csv(claims_table(sorted)));
  for (const Table& table : tables_) write_text(folder / (table.name + ".csv"), to_csv(table));
  for (const Chart& chart : charts_) {
    write_text(folder / (chart.name + ".csv"), to_csv(chart));
    write_text(folder / (chart.name + ".gp"), to_gnuplot(chart));
  }
}

}  // namespace gicube::samples::results
