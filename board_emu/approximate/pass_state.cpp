// What a processor of passes keeps between two runs, for checkpoints.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "pass_processor.h"

namespace gicube::emu {

void PassProcessor::state(Archive& archive) {
  const auto is_empty = [](const auto& queue) { return queue.empty(); };
  archive.expect_idle(std::ranges::all_of(queues_, is_empty) && std::ranges::all_of(from_, is_empty) &&
                          active_rays_.empty() && returned_.empty() && out_.empty() && links_[0].entry.empty() &&
                          links_[1].entry.empty() && waiting_ == 0,
                      "a processor of passes");
  const auto queues = static_cast<std::uint32_t>(queues_.size());
  archive("cache", cache_);
  if (cells_) archive("cells", *cells_);
  archive("importance", importance_);
  archive.field("slots", [this](Archive::Record& record) {
    record(slots_, overflowed_, opened_, openings_, listed_, modified_, contributions_);
  });
  archive.field("sorter", [this](Archive::Record& record) {
    record(active_, resting_, arrived_);
    record.times(sorted_);
    active_rays_.empty_state(record);
    record.at_most(next_input_, 2);
    record.times(others_, taken_from_);
    record(waits_);
    record.times(before_);
  });
  archive("released", released_);
  archive.field("pipeline", [this](Archive::Record& record) {
    record.times(now_, computing_, started_, taken_);
    record(passes_, packets_, in_tree_, stalled_);
    record.times(tree_free_);
    record(link_stalled_, out_blocked_, links_, holds_);
    record.times(held_since_, held_until_);
  });
  archive("counters", counters_);
  archive.within("writes", [&] { writes_.state(archive, (cells_ ? 2 : 1) * queues, cache_.tiles_of_block()); });
  archive.field("splats", [this](Archive::Record& record) {
    record(computing_from_);
    record.times(entered_, room_since_, free_to_compute_, last_out_, link_free_, splat_free_, changed_, fill_free_);
    line_.empty_state(record);
  });
  if (!archive.loads()) return;
  const auto is_queue = [&](const char* field, std::uint32_t queue, bool may_be_none) {
    archive.expect(queue < queues || (may_be_none && queue == kNone), field, "a queue of the processor", queue);
  };
  archive.expect(arrived_ <= active_rays_.end(), "sorter", "no ray behind the last that has come", arrived_);
  archive.expect(active_ == kNone || active_ < shared_.partition->blocks_of(number_), "sorter",
                 "a block of the processor", active_);
  for (std::size_t i = modified_.begin(); i != modified_.end(); ++i) is_queue("slots", modified_[i], false);
  for (std::size_t i = released_.begin(); i != released_.end(); ++i) is_queue("released", released_[i].second, true);
}

}  // namespace gicube::emu
