#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <regex>
#include <stdexcept>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

// As the driver looks for it.
std::filesystem::path board_program() {
  if (const char* given = std::getenv("GICUBE_BOARD")) return given;
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "gicube-board";
}

std::string output_of(const std::string& command) {
  const auto close = [](std::FILE* pipe) { return ::pclose(pipe); };
  const std::unique_ptr<std::FILE, decltype(close)> pipe(::popen(command.c_str(), "r"), close);
  if (!pipe) throw std::runtime_error(command + ": can't be run");
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t size = std::fread(part.data(), 1, part.size(), pipe.get())) text.append(part.data(), size);
  return text;
}

struct Item {
  std::string name, formula, total;
  double bits = 0;
};

// Lines "NAME   FORMULA   BITS bit   3.0 Mb SRAM".
std::vector<Item> items_of(const std::string& text) {
  const std::regex line("(\\S.*?)  +(\\S.*?)? +(\\d+) bit +(.+)");
  std::vector<Item> items;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    std::smatch match;
    const std::string each = text.substr(start, end - start);
    if (std::regex_match(each, match, line)) items.push_back({match[1], match[2], match[4], std::stod(match[3])});
    start = end + 1;
  }
  return items;
}

}  // namespace

void cost_section(Bench& bench) {
  Page& page = bench.page();
  page.heading("Hardware cost");
  const std::filesystem::path program = board_program();
  const std::vector<Item> items = items_of(output_of(fmt::format("'{}' --hardware-cost", program.string())));
  if (items.empty()) throw std::runtime_error(program.string() + " --hardware-cost: no table");
  Table table{"hardware-cost", {"item", "bits", "total"}};
  double edram = 0, sram = 0;
  for (const Item& item : items) {
    table.rows.push_back({item.name, item.formula, item.total});
    if (item.name == "Total SRAM") sram = item.bits;
    if (item.name == "Total eDRAM") edram = item.bits;
  }
  page.text("`gicube-board --hardware-cost` at the paper's design point; Mb = 2^20 bit.");
  page.table(table);
  constexpr double kMb = 1 << 20;
  page.claim({22, "hardware cost (Table 1)", "32 Mb eDRAM, 15 Mb SRAM",
              fmt::format("{:.1f} Mb eDRAM, {:.1f} Mb SRAM", edram / kMb, sram / kMb),
              differs(edram / kMb, 32, 32) || differs(sram / kMb, 15, 15),
              "an item of the table above is not the paper's"});
}

}  // namespace gicube::samples::results
