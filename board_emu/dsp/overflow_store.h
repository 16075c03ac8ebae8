// Keeps rays in the SDRAM until they can be sent again: rays that the ASIC has returned because their queue was full,
// and trapped rays with a new direction [P §3.2].
//
// There is a FIFO list for each queue. A slot that becomes free is reserved for the first ray of the queue's list,
// which is then ready. A ray therefore overflows only once at a full queue, and finds its slot when it returns.
//
// Irradiance carriers overflow too. There are at most dsp.overflow_rays rays, but the number of carriers has no bound:
// a command whose carriers fill the store ends with a fault.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "gicube/archive.h"
#include "levels/dsp_task.h"
#include "words/words.h"

namespace gicube::emu {

// Stores or loads a ray: 8 words from the merge tree or to the ray bus, 8 of the SDRAM; 4 words of the lists, in the
// DSP's own memory, and 8 operations on them. Notifications of reserved slots cost no extra cycles.
inline constexpr DspLoop kStoreRay{"overflowed ray", 0, 8, 8 + 8 + 4};
// Receives a trapped ray and its sample: 16 words from the merge tree. The cycles of its routine are added.
inline constexpr DspLoop kTakeTrap{"trapped ray", 0, 12, 16};

class OverflowStore {
 public:
  static constexpr std::size_t kPlaces = (sdram_map::kCode - sdram_map::kOverflow) / kRayBytesInSdram;

  explicit OverflowStore(std::size_t queues) : lists_(queues) {}

  std::size_t size() const { return kept_; }
  bool has_ready() const { return ready_.first != kNone; }

  // Keeps a ray until its queue has a slot for it, and returns the DSP's task.
  DspTask keep(std::size_t queue, std::uint32_t ray) { return put(lists_[queue], ray, false); }
  // Keeps a ray that can be sent at once, without a reserved slot.
  DspTask keep_ready(std::uint32_t ray) { return put(ready_, ray, false); }
  // The queue has reserved a slot for the first ray of its list. (In a checkpoint the list may be empty.)
  void make_ready(std::size_t queue) {
    if (lists_[queue].first == kNone) return;
    const std::uint32_t place = unlink(lists_[queue]);
    entries_[place].has_slot = true;
    link(ready_, place);
  }

  struct Sent {
    std::uint32_t ray;
    bool has_slot;
    DspTask task;
  };
  Sent send() {
    const std::uint32_t place = unlink(ready_);
    const Entry entry = entries_[place];
    free_.push_back(place);
    --kept_;
    return {entry.ray, entry.has_slot, DspTask{.loop = &kStoreRay}.with(use(place, SdramUse::Kind::kRead))};
  }
  // Between runs the store is empty, but the order of the free entries depends on earlier rays.
  void state(Archive& archive) {
    archive.expect_idle(kept_ == 0, "the store of overflowed rays");
    archive.list("free", free_, kPlaces);
    std::vector<Kept> kept;
    if (archive.in_run()) {
      for (std::size_t list = 0; list <= lists_.size(); ++list) {
        std::uint32_t place = list < lists_.size() ? lists_[list].first : ready_.first;
        for (; place != kNone; place = entries_[place].next) {
          kept.push_back({list, place, entries_[place].ray, entries_[place].has_slot});
        }
      }
      archive.list("kept", kept, kPlaces);
    }
    if (!archive.loads()) return;
    entries_.resize(free_.size() + kept.size());
    std::vector<bool> seen(entries_.size());
    const auto expect_new = [&](const char* name, std::uint32_t place) {
      archive.expect(place < seen.size() && !seen[place], name, "each place once", place);
      seen[place] = true;
    };
    for (const std::uint32_t place : free_) expect_new("free", place);
    for (const Kept& each : kept) {
      expect_new("kept", each.place);
      const TokenLimits* const limits = archive.token_limits();
      const bool is_in_block = each.ray < limits->in_block.size() && limits->in_block[each.ray] != 0;
      archive.expect(each.list <= lists_.size() && is_in_block, "kept", "rays in their blocks, each in a list",
                     each.ray);
      entries_[each.place] = {each.ray, kNone, each.has_slot};
      link(each.list < lists_.size() ? lists_[each.list] : ready_, each.place);
    }
    kept_ = kept.size();
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Entry {
    std::uint32_t ray = 0;
    std::uint32_t next = kNone;
    bool has_slot = false;
  };
  // An entry in a checkpoint. The list after the last queue's is ready_.
  struct Kept {
    std::uint64_t list = 0;
    std::uint32_t place = 0, ray = 0;
    bool has_slot = false;

    void state(Archive::Record& record) { record(list, place, ray, has_slot); }
  };
  struct List {
    std::uint32_t first = kNone, last = kNone;  // entries
  };

  static SdramUse use(std::uint32_t place, SdramUse::Kind kind) {
    return {sdram_map::kOverflow + place * kRayBytesInSdram, kRayBytesInSdram, kind};
  }
  DspTask put(List& list, std::uint32_t ray, bool has_slot) {
    std::uint32_t place = static_cast<std::uint32_t>(entries_.size());
    if (free_.empty()) {
      if (place == kPlaces) {
        throw std::length_error("overflowed rays: expected at most " + std::to_string(kPlaces) +
                                " and their carriers, got more");
      }
      entries_.emplace_back();
    } else {
      place = free_.back();
      free_.pop_back();
    }
    entries_[place] = {ray, kNone, has_slot};
    ++kept_;
    link(list, place);
    return DspTask{.loop = &kStoreRay}.with(use(place, SdramUse::Kind::kWrite));
  }
  void link(List& list, std::uint32_t place) {
    entries_[place].next = kNone;
    (list.first == kNone ? list.first : entries_[list.last].next) = place;
    list.last = place;
  }
  std::uint32_t unlink(List& list) {
    assert(list.first != kNone);
    const std::uint32_t place = list.first;
    list.first = entries_[place].next;
    return place;
  }

  std::size_t kept_ = 0;
  std::vector<List> lists_;  // by queue
  List ready_;
  std::vector<Entry> entries_;       // index: the ray's position in the SDRAM
  std::vector<std::uint32_t> free_;  // unused entries
};

}  // namespace gicube::emu
