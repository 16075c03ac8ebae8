#include "ray_engine.h"

#include <algorithm>
#include <ostream>

#include "datapath/interaction.h"

namespace gicube::emu {

RayEngine::RayEngine(const v1::BoardConfig& config, RayStore& rays, const RayEnginePorts& ports)
    : rays_(rays),
      ports_(ports),
      core_khz_(config.asic().core_khz()),
      dsp_khz_(config.dsp().clock_khz()),
      overflow_cycles_(config.dsp().overflow_ray_cycles()),
      run_rays_(config.dsp().run_rays()),
      run_cycles_(config.dsp().run_cycles()),
      single_queue_(config.sorter().queues() == v1::single) {}

void RayEngine::begin(Cycle now, RaySource& work, const Frame& frame, const Partition& partition, RayRange which) {
  work_ = &work;
  frame_ = &frame;
  partition_ = &partition;
  begin_ = made_ = which.begin;
  end_ = which.end;
  finished_ = rays_made_ = 0;
  making_ = {};
  free_at_ = std::max(free_at_, now * dsp_khz_);
}

Cycle RayEngine::free_at() const { return (free_at_ + dsp_khz_ - 1) / dsp_khz_; }

void RayEngine::work_for(Cycle now, std::uint64_t dsp_cycles) {
  free_at_ = std::max(free_at_, now * dsp_khz_) + dsp_cycles * core_khz_;
  counters_.busy_cycles += dsp_cycles;
}

RayToken RayEngine::launch(std::uint32_t handle) {
  RayUnderWay& ray = rays_[handle];
  const Home& home = partition_->home(ray.block);
  RayToken token;
  token.ray = handle;
  token.processor = home.processor;
  token.queue = single_queue_ ? 0 : home.number;
  token.contribution = contribution(ray.ray_state);
  return token;
}

void RayEngine::take_back(Cycle now) {
  RayToken token = ports_.up.pop(now);
  if (token.state == TokenStatus::kOverflowed) {
    ++counters_.overflows;
    work_for(now, overflow_cycles_ / 2);
    token.state = TokenStatus::kUnderWay;
    kept_.push_back(token);
    return;
  }
  if (token.state == TokenStatus::kTrapped) {
    const Scattered scattered = scatter(now, token);
    if (scattered == Scattered::kSentAgain) return;
    if (scattered == Scattered::kToHost) {
      rays_.remove(token.ray);
      ++finished_;
      return;
    }
  }
  work_->take(index_of_[token.ray], pack(rays_[token.ray].ray_state, *frame_));
  rays_.remove(token.ray);
  ++counters_.taken;
  ++finished_;
  work_for(now, work_->take_cycles());
}

RayEngine::Scattered RayEngine::scatter(Cycle now, RayToken token) {
  RayUnderWay& ray = rays_[token.ray];
  work_for(now, overflow_cycles_ / 2);
  const std::optional<Trap> trap = trap_of(ray.ray_state, *frame_);
  if (!trap) return Scattered::kToHost;
  const ScatterAnswer answer = frame_->routines->scatter(trap->routine, trap->event);
  work_for(now, answer.cycles);
  const Interaction interaction = answer_trap(ray.ray_state, answer, *frame_, counts_);
  if (interaction.outcome == Outcome::kEnded) {
    count_end(ray.ray_state, Termination::kAbsorbed, *frame_, counts_);
    return Scattered::kEnds;
  }
  if (const Termination how = end(ray.ray_state, *frame_); how != Termination::kNot) {
    count_end(ray.ray_state, how, *frame_, counts_);
    return Scattered::kEnds;
  }
  token.state = TokenStatus::kUnderWay;
  ray.block = static_cast<std::uint32_t>(BlockGrid(*frame_->volume).block(ray.ray_state.position));
  kept_.push_back(token);
  return Scattered::kSentAgain;
}

// Makes the next ray; nothing if it never goes to the ASIC.
std::optional<RayToken> RayEngine::make() {
  const std::uint64_t index = made_++;
  const auto made = work_->make(index, making_);
  if (!made) {
    ++finished_;
    return std::nullopt;
  }
  ++rays_made_;
  RayUnderWay ray{0, unpack(*made, *frame_)};
  if (const Termination how = end(ray.ray_state, *frame_);
      how != Termination::kNot) {  // its clipping leaves nothing of it
    count_end(ray.ray_state, how, *frame_, counts_);
    work_->take(index, pack(ray.ray_state, *frame_));
    ++finished_;
    return std::nullopt;
  }
  ray.block = static_cast<std::uint32_t>(BlockGrid(*frame_->volume).block(ray.ray_state.position));
  const std::uint32_t handle = rays_.add(ray);
  if (index_of_.size() <= handle) index_of_.resize(handle + 1);
  index_of_[handle] = index;
  return launch(handle);
}

void RayEngine::make_ray(Cycle now) {
  std::optional<RayToken> ray;
  do {
    ray = make();
  } while (!ray && work_->misses_are_free() && made_ < end_);
  if (!ray && work_->misses_are_free()) return;
  work_for(now, work_->make_cycles());
  if (ray) {
    ray_ = *ray;
    outgoing_ = Outgoing::kRay;
  }
}

void RayEngine::make_run(Cycle now) {
  work_for(now, run_cycles_);
  run_.clear();
  const std::uint64_t last = std::min(work_->row_end(made_), made_ + run_rays_);
  while (made_ < last) {
    if (const auto ray = make()) run_.push_back(*ray);
  }
  if (!run_.empty()) outgoing_ = Outgoing::kRun;
}

// Puts what the DSP has made on the ray bus; false if the bus has no room.
bool RayEngine::send(Cycle now) {
  if (outgoing_ == Outgoing::kRay) {
    if (!ports_.down.can_push(now)) return false;
    ports_.down.push(now, ray_);
    ++counters_.sent;
  } else {
    if (!ports_.runs.can_push(now)) return false;
    ports_.runs.push(now, ports_.pool.add(run_));
    counters_.sent += run_.size();
  }
  outgoing_ = Outgoing::kNothing;
  return true;
}

bool RayEngine::tick(Cycle now) {
  if (busy(now)) return true;
  bool moved = false;
  if (outgoing_ != Outgoing::kNothing) moved = send(now);
  if (ports_.up.can_pop(now)) {
    take_back(now);
    return true;
  }
  if (outgoing_ != Outgoing::kNothing) return moved;
  if (made_ < end_) {
    if (run_rays_ > 1 && work_->row_end(made_) > made_ + 1) {
      make_run(now);
    } else {
      make_ray(now);
    }
    return true;
  }
  if (!kept_.empty()) {
    work_for(now, overflow_cycles_ - overflow_cycles_ / 2);
    ray_ = launch(kept_.front().ray);
    kept_.pop_front();
    outgoing_ = Outgoing::kRay;
    return true;
  }
  return moved;
}

void RayEngine::describe(std::ostream& out) const {
  out << "DSP: " << made_ - begin_ << " of " << end_ - begin_ << " rays made, " << finished_ << " finished, "
      << kept_.size() << " overflowed rays kept, " << rays_.under_way() << " rays under way, "
      << (outgoing_ == Outgoing::kNothing ? "nothing" : "something") << " waits to be sent\n";
}

}  // namespace gicube::emu
