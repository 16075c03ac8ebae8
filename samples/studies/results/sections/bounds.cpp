#include <fmt/format.h>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

void bounds(Bench& bench) {
  Table table{
      "bounds",
      {"scene", "as it is, ms", "perfect memory", "perfect queues", "perfect sorter", "all three", "sharing an RDRAM"}};
  for (const Run& run : bench.oblique()) {
    const auto cell = [&](const Run& other) {
      const double is = asic_ms(bench.get(run)), bound = asic_ms(bench.get(other));
      return fmt::format("{:.1f} ({:+.0f}%)", bound, 100 * (ratio(bound, is) - 1));
    };
    const Run all = run.with("ideal.memory", 1).with("ideal.queues", 1).with("ideal.sorter", 1);
    table.rows.push_back({name_of(run.scene), number(asic_ms(bench.get(run))), cell(run.with("ideal.memory", 1)),
                          cell(run.with("ideal.queues", 1)), cell(run.with("ideal.sorter", 1)), cell(all),
                          cell(run.with("rdram.processors_per_rdram", 2))});
  }
  bench.page().table(table);
}

void causes(Bench& bench) {
  Table table{"causes", {"cause"}};
  for (const Run& run : bench.oblique()) table.columns.push_back(name_of(run.scene));
  add_causes(bench, bench.oblique(), table);
  bench.page().table(table);
}

}  // namespace

void bounds_section(Bench& bench) {
  bench.page().heading("Bounds, and where the cycles go");
  bench.page().text(
      "ASIC time of the oblique view with parts that have no limits: every packet in the cache when it is asked for; "
      "queues that never overflow; the most important queue known at once. The last column is the cost-effective "
      "variant of section 3.3.");
  bounds(bench);
  bench.page().text("Each pipeline cycle has one cause (docs/reference/hardware.md); columns sum to 100%.");
  causes(bench);
}

}  // namespace gicube::samples::results
