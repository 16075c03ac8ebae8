#include "datapath/waiting_rays.h"

#include <string>
#include <utility>

#include "datapath/bricks.h"
#include "datapath/scattering.h"
#include "words/record_list.h"

namespace gicube::emu {

namespace {

template <typename Ray>
std::pair<std::uint16_t, std::uint64_t> order_of(const Ray& ray) {
  return {ray.home, ray.number};
}

}  // namespace

void WaitingRays::begin(WaitingKind kind, const wire::TraceHeader& header) {
  waiting_ = {};
  continued_ = {};
  ended_ = {};
  before_ = first_ = next_ = 0;
  kind_ = kind;
  header_ = header;
  header_.count = 0;
  seen_.clear();
}

void WaitingRays::add(const WaitingRay& ray, std::uint64_t index) {
  const std::lock_guard lock(mutex_);
  expect_room(1);
  WaitingRay& added = waiting_.emplace_back(ray);
  if (const WaitingRay* const before = find(index)) {
    added.number = before->number;
    added.home = before->home;
  } else if (kind_ == WaitingKind::kPicture) {
    added.number = std::uint32_t{ray.ray_state.v} << 16 | ray.ray_state.u;  // no two rays have the same (v, u)
  } else {
    added.number = first_ + index;
  }
}

std::span<const WaitingRay> WaitingRays::take_ready(const Frame& frame) {
  const auto waits = [&frame](const WaitingRay& ray) {
    return ray.trapped ? is_non_resident_for_routine(ray.block, frame) : is_non_resident(ray.block, frame);
  };
  const auto ready = std::partition(waiting_.begin(), waiting_.end(), waits);
  continued_.assign(ready, waiting_.end());
  waiting_.erase(ready, waiting_.end());
  before_ = waiting_.size();
  std::ranges::sort(continued_, {}, order_of<WaitingRay>);
  return continued_;
}

std::vector<WaitingRay> WaitingRays::take(std::span<const std::uint32_t> blocks, std::size_t most) {
  continued_ = {};
  std::ranges::sort(waiting_, {}, order_of<WaitingRay>);  // threads add them in any order
  std::vector<WaitingRay> out;
  std::erase_if(waiting_, [&](const WaitingRay& ray) {
    const bool taken = out.size() < most && std::ranges::binary_search(blocks, ray.block);
    if (taken) out.push_back(ray);
    return taken;
  });
  return out;
}

std::vector<wire::EndedRay> WaitingRays::take_ended(std::size_t most) {
  std::ranges::sort(ended_, {}, order_of<wire::EndedRay>);
  const auto last = ended_.begin() + static_cast<std::ptrdiff_t>(std::min(most, ended_.size()));
  std::vector<wire::EndedRay> out(ended_.begin(), last);
  ended_.erase(ended_.begin(), last);
  return out;
}

void WaitingRays::give(std::span<const WaitingRay> rays) {
  continued_ = {};
  expect_room(rays.size());
  waiting_.insert(waiting_.end(), rays.begin(), rays.end());
  before_ = waiting_.size();
}

std::size_t WaitingRays::count(std::span<const std::uint32_t> blocks) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      waiting_, [&](const WaitingRay& ray) { return std::ranges::binary_search(blocks, ray.block); }));
}

std::uint32_t WaitingRays::trapped_tags() const {
  std::uint32_t tags = 0;
  for (const WaitingRay& ray : waiting_) tags |= ray.trapped ? 1u << (ray.ray_state.flags >> kTrapTagShift) : 0;
  return tags;
}

std::vector<wire::WaitingBlock> WaitingRays::by_block() const {
  std::vector<std::pair<std::uint32_t, std::uint16_t>> rays;
  for (const WaitingRay& ray : waiting_) rays.push_back({ray.block, contribution(ray.ray_state)});
  std::ranges::sort(rays);
  std::vector<wire::WaitingBlock> out;
  for (const auto& [block, contribution] : rays) {
    if (out.empty() || out.back().block != block) out.push_back({block, 0, 0});
    ++out.back().rays;
    out.back().importance += contribution;
  }
  return out;
}

void WaitingRays::state(Archive& archive, std::size_t blocks, const Point& extent, std::size_t kept) {
  archive.at_most("kind", kind_, WaitingKind::kLight);
  archive.field("commands", [this](Archive::Record& record) {
    record.at_most(header_.type, wire::RayType::kBackproject);
    record.at_most(header_.albedo, wire::Albedo::kHigh);
    record.at_most(header_.rules, wire::EnergyRules::kConserving);
    record.at_most(header_.words, wire::SumWords::kWhole);
    record.at_most(header_.opacity, wire::kOpacityOne);
    record(first_, next_);
  });
  archive.bytes("seen", seen_, 0, blocks);
  const auto check = [&](const std::vector<WaitingRay>& rays) {
    for (std::size_t i = 0; archive.loads() && i < rays.size(); ++i) {
      const bool has_place = rays[i].home != 0 || kind_ != WaitingKind::kHostRays ||
                             header_.type == wire::RayType::kDeposit || rays[i].number < kept;
      const bool fits = inside(rays[i].ray_state.position, extent) && rays[i].block < blocks && has_place;
      archive.expect(fits, "rays", "rays in the volume", i);
    }
  };
  archive.list("rays", waiting_);
  check(waiting_);
  archive.at_most("before", before_, waiting_.size());
  archive.list("continued", continued_);
  check(continued_);
  records_state(archive, "ended", ended_, kMax * wire::kEndedRayBytes);
}

void WaitingRays::expect_room(std::size_t more) const {
  if (waiting_.size() + more <= max_) return;
  throw RoutineFault("more than " + std::to_string(max_) + " rays wait for blocks" +
                     (max_ < kMax ? ", for which memory is left (gicube-board --max-memory)" : "") +
                     ": a smaller image or fewer rays would help");
}

bool WaitingRays::note(std::size_t block, std::size_t blocks, std::uint8_t what) {
  seen_.resize(blocks);
  const std::uint8_t before = seen_[block];
  seen_[block] |= what;
  return before != seen_[block] && seen_[block] == (kWaitedFor | kLoaded);
}

}  // namespace gicube::emu
