#include "ray_engine.h"

#include <algorithm>
#include <ostream>

#include "datapath/bricks.h"
#include "datapath/interaction.h"

namespace gicube::emu {

RayEngine::RayEngine(const v1::BoardConfig& config, const Partition& partition, RayStore& rays, RayWatch& watch,
                     const RayEnginePorts& ports)
    : rays_(rays),
      watch_(watch),
      ports_(ports),
      core_khz_(config.asic().core_khz()),
      dsp_khz_(config.dsp().clock_khz()),
      single_queue_(config.sorter().queues() == v1::single),
      partition_(partition),
      lists_(std::max<std::size_t>(1, partition.max_blocks())),
      dsp_(config),
      slots_(config.dsp().overflow_rays()),
      may_be_under_way_(slots_),
      store_(config.asic().processors() * lists_) {}

void RayEngine::begin(Cycle now, RaySource& work, const Frame& frame, RayRange which, FunctionalTrace* ahead) {
  set_out(work, frame, which);
  ahead_ = ahead;
  begin_ = made_ = which.begin;
  end_ = which.end;
  finished_ = rays_made_ = under_way_ = 0;
  making_ = {};
  batch_ = 0;
  free_at_ = std::max(free_at_, dsp_cycle(now));
}

void RayEngine::go_on(RaySource& work, const Frame& frame, RayRange which) {
  const bool fits = begin_ == which.begin && end_ == which.end && end_ <= work.count();
  if (!fits) throw CheckpointFault("run", "a range of the command's rays", std::to_string(end_));
  set_out(work, frame, which);
  ahead_ = nullptr;
}

void RayEngine::set_out(RaySource& work, const Frame& frame, RayRange which) {
  work_ = &work;
  frame_ = &frame;
  may_be_under_way_ = std::min<std::uint64_t>(slots_, work.max_under_way());
  rays_.make_room(std::min<std::uint64_t>(may_be_under_way_, which.end - which.begin));  // keeps references valid
}

void RayEngine::stop_ahead() {
  if (ahead_ == nullptr || ahead_->has_stopped()) return;
  const std::vector<bool> in_use = rays_.in_use();
  for (std::uint32_t handle = 0; handle < in_use.size(); ++handle) {
    if (!in_use[handle]) continue;
    const FunctionalTrace::Ray& ray = rays_ahead_[handle];
    RayState& ray_state = rays_[handle].ray_state;
    ray_state = ahead_->at(ray, ray.steps - ray_state.steps_left(), counts_);
  }
  ahead_->stop(counts_);
}

void RayEngine::run_state(Archive& archive) {
  archive.field("run", [this](Archive::Record& record) {
    record(begin_, end_);
    record.at_most(made_, end_);
    record(rays_made_, finished_, making_, under_way_, batch_);
    record.at_most(outgoing_, Outgoing::kRun);
    if (outgoing_ == Outgoing::kRay) record(ray_);
    if (outgoing_ == Outgoing::kRun) record.list(run_, ~std::uint64_t{0});
  });
  if (!archive.loads()) {
    index_of_.resize(std::max(index_of_.size(), rays_.handles()));
    for (std::uint64_t& index : index_of_) {
      if (index < begin_ || index >= made_) index = begin_;  // index of an earlier run
    }
  }
  archive.list("index", index_of_);
  const bool fits = index_of_.size() >= rays_.handles() && (begin_ < made_ || rays_.under_way() == 0);
  const auto is_made = [this](std::uint64_t index) { return index == begin_ || (index > begin_ && index < made_); };
  archive.expect(fits && std::ranges::all_of(index_of_, is_made), "index", "rays of the run for all handles",
                 index_of_.size());
}

Cycle RayEngine::free_at() const { return (free_at_ * core_khz_ + dsp_khz_ - 1) / dsp_khz_; }

RayToken RayEngine::launch(std::uint32_t handle) {
  RayUnderWay& ray = rays_[handle];
  const Home& home = partition_.home(ray.block);
  RayToken token;
  token.ray = handle;
  token.processor = home.processor;
  token.queue = single_queue_ ? 0 : home.number;
  token.contribution = contribution(ray.ray_state);
  token.watched = watch_.watches(handle);
  return token;
}

void RayEngine::take_back(Cycle now) {
  RayToken token = ports_.up.pop(now);
  if (token.state == TokenStatus::kSlot) {
    store_.make_ready(list_of(token.processor, token.queue));
    return;
  }
  if (token.state == TokenStatus::kOverflowed) {
    ++counters_.overflows;
    report(now, RayStep::kKept, token);
    carry_out(now, single_queue_ ? store_.keep_ready(token.ray)
                                 : store_.keep(list_of(token.processor, token.queue), token.ray));
    return;
  }
  settle(now, token);
}

void RayEngine::settle(Cycle now, const RayToken& token) {
  const RayUnderWay& carrier = rays_[token.ray];
  if (token.state == TokenStatus::kNonResident && carrier.ray_state.is(wire::kIrradianceCarrier)) {
    give_host(brought_by(carrier.ray_state, *frame_).deposit, *frame_, carrier.block);
    rays_.remove(token.ray);
    return carry_out(now, {.loop = &kPassRay});
  }
  Scattered scattered = Scattered::kEnds;
  if (token.state == TokenStatus::kTrapped) {
    scattered = scatter(now, token);
    if (scattered == Scattered::kSentAgain) return;
  } else if (token.state == TokenStatus::kNonResident) {
    wait(now, token, false);
    scattered = Scattered::kWaits;
  }
  if (scattered == Scattered::kWaits) {
    report(now, RayStep::kWaits, token);
    rays_.remove(token.ray);
    --under_way_;
    ++finished_;
    return;
  }
  const wire::Ray ray =
      computes_ahead() ? rays_ahead_[token.ray].ended : pack_ended(rays_[token.ray].ray_state, *frame_);
  work_->take(index_of_[token.ray], ray);
  report(now, RayStep::kTaken, token);
  rays_.remove(token.ray);
  --under_way_;
  ++counters_.taken;
  ++finished_;
  carry_out(now, work_->looking(ray));
  carry_out(now, work_->taking(index_of_[token.ray]));
}

void RayEngine::wait(Cycle now, const RayToken& token, bool is_trapped) {
  const RayUnderWay& ray = rays_[token.ray];
  frame_->waiting->add({.ray_state = ray.ray_state, .block = ray.block, .trapped = is_trapped}, index_of_[token.ray]);
  carry_out(now, {.loop = &kPassRay});
}

RayEngine::Scattered RayEngine::scatter(Cycle now, const RayToken& token) {
  RayUnderWay& ray = rays_[token.ray];
  const BlockGrid grid(*frame_->volume);
  ray.block = static_cast<std::uint32_t>(grid.block(ray.ray_state.position));
  if (is_non_resident_for_routine(ray.block, *frame_)) {
    wait(now, token, true);
    return Scattered::kWaits;
  }
  const std::optional<Trap> trap = trap_of(ray.ray_state, *frame_);
  DspTask task{.loop = &kTakeTrap};
  if (!trap) {
    carry_out(now, task);
    return Scattered::kWaits;
  }
  const ScatterAnswer answer = frame_->routines->scatter(trap->routine, trap->event);
  task.more_cycles = answer.cycles;
  carry_out(now, task);
  const Interaction interaction = answer_trap(ray.ray_state, answer, *frame_, counts_);
  report(now, RayStep::kScattered, token, answer.cycles);
  if (interaction.outcome == Outcome::kEnded) {
    count_end(ray.ray_state, Termination::kAbsorbed, *frame_, counts_);
    return Scattered::kEnds;
  }
  if (const Termination how = end(ray.ray_state, *frame_); how != Termination::kActive) {
    count_end(ray.ray_state, how, *frame_, counts_);
    return Scattered::kEnds;
  }
  ray.block = static_cast<std::uint32_t>(grid.block(ray.ray_state.position));
  if (is_non_resident(ray.block, *frame_)) {
    wait(now, token, false);
    return Scattered::kWaits;
  }
  carry_out(now, store_.keep_ready(token.ray));
  return Scattered::kSentAgain;
}

// Makes the next ray. Returns nothing if it does not go to the ASIC.
std::optional<RayToken> RayEngine::make(Cycle now) {
  const std::uint64_t index = made_++;
  std::optional<FunctionalTrace::Ray> traced;
  if (ahead_ != nullptr) traced = ahead_->make(index, making_, counts_);
  const std::optional<wire::Ray> made = ahead_ == nullptr ? work_->make(index, making_)
                                        : traced          ? std::optional(traced->made)
                                                          : std::nullopt;
  if (!made) {
    ++finished_;
    return std::nullopt;
  }
  ++rays_made_;
  RayUnderWay ray{0, begin_or_go_on(*made, index, *frame_)};
  const WaitingRay* const waited = frame_->in_bricks() ? frame_->waiting->find(index) : nullptr;
  const bool is_trapped = waited != nullptr && waited->trapped;
  if (const Termination how = end(ray.ray_state, *frame_);
      how != Termination::kActive && !is_trapped) {  // clipping leaves nothing of it
    count_end(ray.ray_state, computes_ahead() ? Termination::kLeft : how, *frame_, counts_);
    work_->take(index, pack_ended(ray.ray_state, *frame_));
    ++finished_;
    return std::nullopt;
  }
  ray.block = static_cast<std::uint32_t>(BlockGrid(*frame_->volume).block(ray.ray_state.position));
  if (is_non_resident(ray.block, *frame_) && !is_trapped) {
    frame_->waiting->add({.ray_state = ray.ray_state, .block = ray.block}, index);
    ++finished_;
    return std::nullopt;
  }
  const std::uint32_t handle = rays_.add(ray);
  if (index_of_.size() <= handle) index_of_.resize(handle + 1);
  index_of_[handle] = index;
  if (computes_ahead()) {
    rays_ahead_.resize(index_of_.size());
    rays_ahead_[handle] = *traced;
    rays_[handle].ray_state.set_steps_left(traced->steps);
  }
  ++under_way_;
  watch_.made(now, handle, index, *made);
  if (is_trapped) {
    settle(now, {.ray = handle, .state = TokenStatus::kTrapped, .watched = watch_.watches(handle)});
    return std::nullopt;
  }
  return launch(handle);
}

void RayEngine::make_ray(Cycle now) {
  std::optional<RayToken> ray;
  std::uint64_t which = made_;
  do {
    which = made_;
    ray = make(now);
  } while (!ray && work_->misses_are_free() && made_ < end_);
  if (!ray && work_->misses_are_free()) return;
  carry_out(now, work_->making(which));
  if (ray) {
    ray_ = *ray;
    outgoing_ = Outgoing::kRay;
  }
}

void RayEngine::make_run(Cycle now, std::uint64_t last) {
  carry_out(now, work_->making(made_));
  run_.clear();
  last = std::min(last, made_ + may_be_under_way_ - under_way_);
  while (made_ < last) {
    if (const auto ray = make(now)) run_.push_back(*ray);
  }
  if (!run_.empty()) outgoing_ = Outgoing::kRun;
}

void RayEngine::make_rays(Cycle now) {
  const std::uint64_t last = std::min(end_, work_->run_end(made_));
  if (last > made_ + 1) {
    make_run(now, last);
  } else {
    make_ray(now);
  }
}

// Sends an overflowed ray to its queue.
void RayEngine::send_again(Cycle now) {
  const OverflowStore::Sent again = store_.send();
  carry_out(now, again.task);
  ray_ = launch(again.ray);
  ray_.has_reserved_slot = again.has_slot;
  outgoing_ = Outgoing::kRay;
}

// Puts the outgoing ray or run on the ray bus. Returns false if the bus has no room.
bool RayEngine::send(Cycle now) {
  if (outgoing_ == Outgoing::kRay) {
    if (!ports_.down.can_push(now)) return false;
    report(now, RayStep::kSent, ray_, sends_again_ ? 1 : 0);
    ports_.down.push(now, ray_);
    ++counters_.sent;
  } else {
    if (!ports_.runs.can_push(now)) return false;
    for (const RayToken& ray : run_) report(now, RayStep::kSent, ray);
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
  const bool free = outgoing_ == Outgoing::kNothing;
  if (free && batch_ > 0 && !ports_.up.was_full(now) && (sends_again_ ? store_.has_ready() : may_make())) {
    --batch_;
    sends_again_ ? send_again(now) : make_rays(now);
    return true;
  }
  batch_ = 0;
  if (ports_.up.can_pop(now)) {
    take_back(now);
    return true;
  }
  if (!free) return moved;
  sends_again_ = store_.has_ready();
  if (!sends_again_ && !may_make()) return moved;
  batch_ = Dsp::kBatch - 1;
  sends_again_ ? send_again(now) : make_rays(now);
  return true;
}

void RayEngine::dump(std::ostream& out) const {
  out << "DSP: " << made_ - begin_ << " of " << end_ - begin_ << " rays made, " << finished_ << " finished, "
      << store_.size() << " overflowed rays kept, " << rays_.under_way() << " rays under way, "
      << (outgoing_ == Outgoing::kNothing ? "nothing" : "something") << " waits to be sent\n";
}

}  // namespace gicube::emu
