// The registers of the sorter in SystemVerilog, compared with those that the part lists.
#pragma once

#include <algorithm>
#include <string>

#include "asic/sorter/sorter.h"
#include "lockstep.h"
#include "token_bits.h"

namespace gicube::emu::lockstep {

class QueueRegisters {
 public:
  static constexpr std::size_t kImportanceBits = 32;

  template <typename Rtl>
  QueueRegisters(const Rtl& rtl, std::uint32_t queues, std::uint32_t capacity, const TokenBits& form)
      : capacity_(capacity), form_(form) {
    for (const char* name :
         {"has_active", "active", "latest_active", "issued_since_active", "turn", "openings", "waiting"}) {
      control_.push_back(rtl.find(name));
    }
    for (std::uint32_t queue = 0; queue < queues; ++queue) {
      const std::string at = "gen_queue[" + std::to_string(queue) + "].one.";
      queues_.push_back({rtl.find(at + "edram"), rtl.find(at + "head"), rtl.find(at + "waiting"),
                         rtl.find(at + "slots"), rtl.find(at + "overflowed"), rtl.find(at + "opened")});
    }
    selected_ = rtl.find("ranks.selected");
    comparison_ = rtl.find("ranks.comparison");
    changed_ = rtl.find("changed.list");
    changes_ = rtl.find("changed.count");
    reserved_ = rtl.find("reserved.items");
    reserves_ = rtl.find("reserved.size");
  }

  std::uint64_t issued_since_active() const { return control_[3](); }
  std::uint64_t reserved() const { return reserves_(); }
  std::uint64_t most_waiting() const {
    std::uint64_t most = 0;
    for (const Queue& queue : queues_) most = std::max(most, queue.waiting());
    return most;
  }

  // The first register that differs from the part's; "" if none does.
  std::string difference(const Registers& part, const SorterCounters& counters) const {
    if (part["counters"] != listed(counters)) return "counters";
    const std::uint64_t active = control_[0]() != 0 ? control_[1]() : 0xFFFF'FFFF;
    const auto differs = [&part](const std::string& name, const Numbers& rtl) { return part[name] != rtl; };
    if (differs("active", {active})) return "active";
    if (differs("latest_active", {control_[2]()})) return "latest_active";
    if (differs("issued_since_active", {control_[3]()})) return "issued_since_active";
    if (differs("turn", {control_[4]()})) return "turn";
    if (differs("queues.openings", {control_[5]()})) return "openings";
    if (differs("kept", list(reserved_, reserves_()))) return "reserved";
    if (differs("changed", list(changed_, changes_()))) return "changed";
    if (const std::string text = queues_difference(part); !text.empty()) return text;
    return ranks_difference(part, active);
  }

 private:
  struct Queue {
    Register edram, head, waiting, slots, overflowed, opened;
  };

  static Numbers listed(SorterCounters counters) {
    Numbers numbers;
    NumbersArchive archive(false, numbers);
    archive("", counters);
    return numbers;
  }
  Numbers list(const Register& items, std::uint64_t count) const {
    Numbers out{count};
    for (std::uint64_t i = 0; i < count; ++i) out.push_back(items(i * form_.queue, form_.queue));
    return out;
  }

  std::string queues_difference(const Registers& part) const {
    Numbers used{0};
    std::uint64_t waiting = 0;
    for (std::uint32_t number = 0; number < queues_.size(); ++number) {
      const Queue& queue = queues_[number];
      waiting += queue.waiting();
      if (queue.slots() == 0 && queue.overflowed() == 0) continue;
      used.push_back(number);
      ++used[0];
      Numbers all{queue.slots(), queue.overflowed(), queue.opened(), queue.waiting()};
      for (std::uint64_t i = 0; i < queue.waiting(); ++i) {
        const RayToken token = form_.from(queue.edram.entry((queue.head() + i) % capacity_));
        all.insert(all.end(), {token.ray, token.queue, token.contribution, token.processor,
                               static_cast<std::uint64_t>(token.state), token.has_reserved_slot ? 1u : 0u});
      }
      const std::string name = "queue" + std::to_string(number);
      if (part["queues." + name] != all) return name;
    }
    if (part["queues.used"] != used) return "used";
    return control_[6]() == waiting ? "" : "waiting";
  }

  // Keys of the part: the importance above the complement of the queue.
  std::uint64_t key(const Register& items, std::size_t rank) const {
    const std::size_t width = kImportanceBits + form_.queue;
    const std::uint64_t importance = items(rank * width + form_.queue, kImportanceBits);
    if (importance == 0) return 0;
    const std::uint64_t queue = ~items(rank * width, form_.queue) & ((std::uint64_t{1} << form_.queue) - 1);
    return importance << 32 | (~queue & 0xFFFF'FFFF);
  }
  std::string ranks_difference(const Registers& part, std::uint64_t active) const {
    const Numbers &selected = part["ranks.selected"], &moving = part["ranks.moving"];
    const std::uint64_t origin = part.number("ranks.origin"), ranks = queues_.size();
    Numbers comparisons(ranks, 0), inserted(ranks, 0);
    for (std::size_t i = 1; i + 1 < moving.size(); i += 2) {
      if (moving[i] != 0) comparisons.at(moving[i + 1] - origin) = moving[i];
    }
    std::uint64_t size = 0;
    const auto holds = [&](std::uint64_t item) {
      if (item == 0) return;
      ++size;
      inserted.at(~item & 0xFFFF'FFFF) = item;
    };
    for (std::size_t rank = 0; rank < ranks; ++rank) {
      const std::uint64_t upper = key(selected_, rank), lower = key(comparison_, rank);
      if (upper != selected[origin + rank]) return "selected of rank " + std::to_string(rank);
      if (lower != comparisons[rank]) return "comparison of rank " + std::to_string(rank);
      holds(upper);
      holds(lower);
    }
    if (size != part.number("ranks.size")) return "size of the ranks";
    if ((key(comparison_, 0) != 0) != (part.number("ranks.entering") != 0)) return "entering";
    // The part keeps an active queue's importance of before; the chip has only the infinite one.
    if (active < ranks) inserted[active] = part["ranks.inserted"][active];
    return inserted == part["ranks.inserted"] ? "" : "inserted";
  }

  std::uint32_t capacity_;
  TokenBits form_;
  std::vector<Register> control_;
  std::vector<Queue> queues_;
  Register selected_, comparison_, changed_, changes_, reserved_, reserves_;
};

}  // namespace gicube::emu::lockstep
