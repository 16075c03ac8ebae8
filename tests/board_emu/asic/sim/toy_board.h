// Sorters, bus, ring and tree closed to a loop by toy pipelines and a toy DSP, whose rays go where a hash of ray and
// hop sends them. For tests of what only the loop shows: conservation, progress, and that the order of ticks does not
// matter.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "asic/link/ring.h"
#include "asic/raybus/merge_tree.h"
#include "asic/raybus/ray_bus.h"
#include "asic/sorter/sorter.h"
#include "dsp/overflow_store.h"

namespace gicube::emu {

struct ToyScene {
  std::uint32_t processors = 4;
  std::uint32_t queues = 8;
  std::uint32_t rays = 300;
  std::uint32_t link_bits = 64;
  bool runs = false;  // half of the rays are sent as runs
  SorterSetup sorter = {};
};

// One event a ray takes part in: when, which, how far.
struct ToyEvent {
  Cycle cycle;
  std::uint32_t ray;
  std::uint32_t hop;
  friend bool operator==(const ToyEvent&, const ToyEvent&) = default;
};

class ToyProcessor {
 public:
  ToyProcessor(const ToyScene& scene, std::uint8_t number, std::vector<std::uint32_t>& hops)
      : scene_(scene),
        number_(number),
        hops_(hops),
        sorter_(of_processor(scene.sorter, number), {returned, bus, left, right, released}, {issue, overflow}) {}

  void tick_sorter(Cycle now) { sorter_.tick(now); }

  // In order, eight cycles long; the last stage waits until there is room wherever a ray may go.
  void tick_pipeline(Cycle now) {
    if (!stages_.empty() && stages_.front().second + 8 <= now && returned.can_push(now) && released.can_push(now) &&
        out.can_push(now) && done.can_push(now)) {
      leave(now, stages_.front().first);
      stages_.pop_front();
    }
    if (stages_.size() < 8 && issue.can_pop(now)) stages_.emplace_back(issue.pop(now), now);
  }

  // Where a ray goes after `hop` hops: like a hash, the same in every run.
  static RayToken aim(const ToyScene& scene, std::uint32_t ray, std::uint32_t hop) {
    std::uint32_t h = (ray * 2654435761u) ^ ((hop / 3) * 2246822519u);  // three samples in a queue
    h = (h ^ (h >> 15)) * 2246822519u;
    return {.ray = ray,
            .queue = (h >> 8) % scene.queues,
            .contribution = static_cast<std::uint16_t>(h >> 20),
            .processor = static_cast<std::uint8_t>(h % scene.processors)};
  }

  Fifo<RayToken> returned{2}, bus{2}, left{2}, right{2}, issue{2}, overflow{2}, out{2}, done{2};
  Fifo<std::uint32_t> released{2};
  std::vector<ToyEvent> log;
  const Sorter& sorter() const { return sorter_; }

 private:
  static SorterSetup of_processor(SorterSetup setup, std::uint8_t number) {
    setup.processor = number;
    return setup;
  }
  void leave(Cycle now, const RayToken& from) {
    const std::uint32_t hop = ++hops_[from.ray];
    log.push_back({now, from.ray, hop});
    RayToken to = aim(scene_, from.ray, hop);
    const bool is_done = hop >= 12 + from.ray % 7;
    if (!is_done && to.processor == number_ && (scene_.sorter.single || to.queue == from.queue)) {
      to.has_reserved_slot = true;
      returned.push(now, to);
      return;
    }
    released.push(now, from.queue);
    if (is_done) to.state = TokenStatus::kDone;
    (is_done ? done : to.processor == number_ ? returned : out).push(now, to);
  }

  ToyScene scene_;
  std::uint8_t number_;
  std::vector<std::uint32_t>& hops_;
  std::deque<std::pair<RayToken, Cycle>> stages_;
  Sorter sorter_;
};

class ToyBoard {
 public:
  explicit ToyBoard(const ToyScene& scene) : scene_(scene), hops_(scene.rays, 0), finished_(scene.rays, 0) {
    scene_.sorter.queues = scene.queues;
    std::vector<Fifo<RayToken>*> from_bus, leaves;
    std::vector<Ring::Port> ports;
    for (std::uint32_t i = 0; i < scene.processors; ++i) {
      processors_.push_back(std::make_unique<ToyProcessor>(scene_, static_cast<std::uint8_t>(i), hops_));
      ToyProcessor& p = *processors_.back();
      from_bus.push_back(&p.bus);
      leaves.insert(leaves.end(), {&p.done, &p.overflow});
      ports.push_back({&p.out, &p.left, &p.right});
      ticks_.push_back([&p](Cycle now) { p.tick_sorter(now); });
      ticks_.push_back([&p](Cycle now) { p.tick_pipeline(now); });
    }
    bus_ = std::make_unique<RayBus>(down_, runs_, pool_, from_bus);
    tree_ = std::make_unique<MergeTree>(leaves, up_);
    ring_ = std::make_unique<Ring>(scene.link_bits, 2, ports);
    ticks_.push_back([this](Cycle now) { bus_->tick(now); });
    ticks_.push_back([this](Cycle now) { tree_->tick(now); });
    ticks_.push_back([this](Cycle now) { ring_->tick(now); });
    ticks_.push_back([this](Cycle now) { tick_dsp(now); });
  }

  // Until all rays are done, at most `limit` cycles. Seed 0: always in the same order.
  void run(Cycle limit, unsigned seed) {
    std::mt19937 random(seed);
    for (now_ = 0; done_ < scene_.rays && now_ < limit; ++now_) {
      if (seed != 0) std::shuffle(ticks_.begin(), ticks_.end(), random);
      for (const auto& tick : ticks_) tick(now_);
    }
  }

  Cycle cycles() const { return now_; }
  const std::vector<int>& finished() const { return finished_; }  // times, by ray
  const std::vector<std::uint32_t>& hops() const { return hops_; }
  const ToyProcessor& processor(std::size_t i) const { return *processors_[i]; }
  std::uint64_t overflows() const { return overflows_; }
  bool idle() const {
    return bus_->idle() && tree_->idle() && ring_->idle() && pool_.in_use() == 0 &&
           std::all_of(processors_.begin(), processors_.end(), [](const auto& p) { return p->sorter().idle(); });
  }

 private:
  // Takes rays back, sends overflowed ones again, makes new ones. Stalls now and then.
  void tick_dsp(Cycle now) {
    if (now % 5 != 0 && up_.can_pop(now)) {
      RayToken token = up_.pop(now);
      if (token.state == TokenStatus::kDone) {
        ++finished_[token.ray];
        ++done_;
      } else if (token.state == TokenStatus::kSlot) {
        store_.make_ready(list_of(token));
      } else {
        ++overflows_;
        if (scene_.sorter.bus_waits) {
          store_.keep_ready(token.ray);
        } else {
          store_.keep(list_of(token), token.ray);
        }
      }
    }
    if (scene_.runs && made_ % 16 == 0 && made_ + 8 <= scene_.rays && runs_.can_push(now)) {
      std::vector<RayToken> run;
      for (int i = 0; i < 8; ++i) run.push_back(ToyProcessor::aim(scene_, made_++, 0));
      runs_.push(now, pool_.add(run));
    } else if (down_.can_push(now) && store_.has_ready()) {
      const OverflowStore::Sent again = store_.send();
      RayToken token = ToyProcessor::aim(scene_, again.ray, hops_[again.ray]);
      token.has_reserved_slot = again.has_slot;
      down_.push(now, token);
    } else if (down_.can_push(now) && made_ < scene_.rays) {
      down_.push(now, ToyProcessor::aim(scene_, made_++, 0));
    }
  }

  std::size_t list_of(const RayToken& token) const { return token.processor * scene_.queues + token.queue; }

  ToyScene scene_;
  std::vector<std::uint32_t> hops_;
  std::vector<int> finished_;
  std::uint32_t made_ = 0;
  std::uint32_t done_ = 0;
  std::uint64_t overflows_ = 0;
  OverflowStore store_{std::size_t{scene_.processors} * scene_.queues};
  Fifo<RayToken> down_{2}, up_{2};
  Fifo<RunPool::Run> runs_{2};
  RunPool pool_{scene_.processors};
  std::vector<std::unique_ptr<ToyProcessor>> processors_;
  std::unique_ptr<RayBus> bus_;
  std::unique_ptr<MergeTree> tree_;
  std::unique_ptr<Ring> ring_;
  std::vector<std::function<void(Cycle)>> ticks_;
  Cycle now_ = 0;
};

}  // namespace gicube::emu
