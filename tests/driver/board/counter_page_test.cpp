// docs/reference/counters.csv names what boards of all levels count, with unit and level.
#include <regex>

#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

struct CounterRow {
  std::string name, unit, level;
  std::regex pattern;
};

std::string replaced(std::string text, const std::string& what, const std::string& in_its_place) {
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + in_its_place.size())) {
    text.replace(at, what.size(), in_its_place);
  }
  return text;
}

// Parts of one kind may have a number.
std::regex pattern_of(const std::string& name) {
  std::string text = replaced(name, ".", "\\.");
  text = replaced(text, "<n>", "[0-9]+");
  text = replaced(text, "<level>", "(functional|cycle)");
  text = replaced(text, "<command>", "(render|trace|illuminate|resume|pairs|continue)");
  text = replaced(text, "<cargo>", "(register|table|volume|command|rays|image|completion)");
  text = replaced(text, "<part>", "[a-z_]+");
  return std::regex(std::regex_replace(text, std::regex("^(processor|link|rdram)"), "$1[0-9]*"));
}

std::vector<CounterRow> rows_of_the_table() {
  std::ifstream table(GICUBE_SOURCE_DIR "/docs/reference/counters.csv");
  const std::regex row("([^,]*),([^,]*),([^,]*),.*");
  std::vector<CounterRow> rows;
  std::string line;
  std::getline(table, line);  // the columns' names
  while (std::getline(table, line)) {
    std::smatch cells;
    if (!std::regex_match(line, cells, row))
      ADD_FAILURE() << line;
    else
      rows.push_back({cells[1], cells[2], cells[3], pattern_of(cells[1])});
  }
  return rows;
}

// Whether a board on which this level has answered keeps it; `lit`: light has been scattered or deposited.
bool keeps(const CounterRow& row, Fidelity level, bool lit) {
  if (row.level == "lit") return lit;
  return row.level == "all" || row.level == name_of(level);
}

TEST(CounterPage, NamesEveryCounterOfABoardAndNoOther) {
  const std::vector<CounterRow> rows = rows_of_the_table();
  ASSERT_GT(rows.size(), 80u);
  const auto compare = [&rows](const Counters& counters, const auto& is_kept, const std::string& when) {
    for (const Counter& counter : counters.list()) {
      const auto fits = [&](const CounterRow& row) {
        return is_kept(row) && row.unit == counter.unit && std::regex_match(counter.name, row.pattern);
      };
      EXPECT_EQ(std::ranges::count_if(rows, fits), 1) << counter.name << " (" << counter.unit << ") " << when;
    }
    for (const CounterRow& row : rows) {
      const auto is_it = [&row](const Counter& counter) { return std::regex_match(counter.name, row.pattern); };
      EXPECT_EQ(std::ranges::any_of(counters.list(), is_it), is_kept(row)) << row.name << ' ' << when;
    }
  };
  const BoxVolume volume(16, 4, 11);
  for (const std::string name : {"functional", "cycle"}) {
    Board board = Board::open(kSmallBlocks + ("&fidelity=" + name));
    const Fidelity level = board.info().fidelity;
    board.load_volume(volume.view());
    board.set_transfer_function(step_function(0.5));
    board.set_material({.scattering = 0.5, .bsdf = Bsdf::kIsotropic});
    board.render(front_view(16));
    const std::vector<Element> patches{{.origin = {1, 1, 1}, .u = {9, 0, 0}, .v = {0, 9, 0}},
                                       {.origin = {1, 1, 14}, .u = {0, 9, 0}, .v = {9, 0, 0}}};
    board.pair_factors(patches, std::vector<ElementPair>{{0, 1, 0}}, {.rays = 16});
    compare(
        board.counters(), [=](const CounterRow& row) { return keeps(row, level, false); }, name);
    board.illuminate(std::vector<Light>{PointLight{{8, 8, -9}, 1}}, {});
    compare(
        board.counters(), [=](const CounterRow& row) { return keeps(row, level, true); }, name + ", lit");
  }
}

}  // namespace
}  // namespace gicube
