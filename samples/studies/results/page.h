// The page of results: Markdown, and a CSV file of the same cells for each table and chart.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace gicube::samples::results {

struct Table {
  std::string name;  // of its file, NAME.csv
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows = {};  // cells as they are printed
};

// A picture drawn by gnuplot from NAME.csv: x in the first column, a series in each other.
struct Chart {
  std::string name;
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  bool bars = false;  // a group of bars for each point, labelled by its x
  std::vector<std::string> series = {};
  // x, and a value a series; not-a-number where a series has none.
  std::vector<std::pair<double, std::vector<double>>> points = {};
};

// One of the paper's claims beside ours.
struct Claim {
  int number = 0;
  std::string claim, paper, ours;
  bool differs = false;  // by more than a quarter
  std::string why;       // needed if it differs
};

// Ours lies more than a quarter outside of low..high.
bool differs(double ours, double low, double high);

class Page {
 public:
  void heading(const std::string& text);
  void text(const std::string& text);
  void table(const Table& table);
  void chart(const Chart& chart, const std::string& caption);
  void picture(const std::string& file, const std::string& caption);
  // Throws std::logic_error if it differs and does not say why.
  void claim(const Claim& claim);

  // All claims as a table, and a list of the reasons of those that differ.
  std::string claims() const;
  const std::string& body() const { return body_; }
  // Writes the CSV files and gnuplot scripts into `folder`. Throws InputError if a file can't be written.
  void write_files(const std::filesystem::path& folder) const;

 private:
  std::string body_;
  std::vector<Table> tables_;
  std::vector<Chart> charts_;
  std::vector<Claim> claims_;
};

std::string to_markdown(const Table& table);
// Cells with commas or quotes in quotes, as RFC 4180.
std::string to_csv(const Table& table);
std::string to_csv(const Chart& chart);
// Reads NAME.csv and writes NAME.svg in the working folder.
std::string to_gnuplot(const Chart& chart);

// "12.3", "0.05": `digits` after the point. "12%" of 0.12.
std::string number(double value, int digits = 1);
std::string percent(double share, int digits = 0);

}  // namespace gicube::samples::results
