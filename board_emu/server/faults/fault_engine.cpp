#include "fault_engine.h"

#include "fault_plan.h"

namespace gicube::emu {
namespace {

using v1::PlannedFault;

// The finaliser of SplitMix64 [Steele, Lea, Flood, OOPSLA 2014].
std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

// What is drawn for a message: whether, which kind, and its parameters are independent of one another.
enum class Purpose : std::uint64_t { kHit, kKind, kFirst, kSecond };

std::uint64_t chance(std::uint64_t stream, std::uint64_t message, Purpose purpose) {
  return mix(mix(stream ^ message) ^ static_cast<std::uint64_t>(purpose));
}

}  // namespace

FaultEngine::FaultEngine(const v1::FaultPlan& plan) {
  for (const PlannedFault& fault : plan.fault()) {
    lanes_[lane(fault.direction())].planned.emplace(fault.message(), fault);
  }
  std::uint64_t part = 0;
  for (const v1::RandomFaults& rule : plan.random()) {
    ++part;
    for (const PlannedFault::Direction direction : {PlannedFault::down, PlannedFault::up}) {
      if (rule.has_direction() && rule.direction() != direction) continue;
      // Parts with one seed, and the directions of one part, are independent of one another.
      const std::uint64_t stream = mix(mix(mix(rule.seed()) ^ part) ^ static_cast<std::uint64_t>(direction));
      Random random{rule, stream, {}};
      for (int i = 0; i < rule.kinds_size(); ++i) {
        if (direction == PlannedFault::down || !is_memory_fault(rule.kinds(i))) random.kinds.push_back(rule.kinds(i));
      }
      if (!random.kinds.empty()) lanes_[lane(direction)].random.push_back(std::move(random));
    }
  }
}

std::optional<PlannedFault> FaultEngine::next(PlannedFault::Direction direction, std::size_t frame_bytes) {
  Lane& lane = lanes_[this->lane(direction)];
  const std::uint64_t message = ++lane.message;
  std::optional<PlannedFault> hit;
  // Each draws for itself, so that a named fault or another part does not move what comes later.
  for (Random& random : lane.random) {
    auto drawn = draw(random, direction, message);
    if (drawn && !hit) hit = std::move(drawn);
  }
  const auto planned = lane.planned.find(message);
  if (planned != lane.planned.end()) hit = planned->second;
  if (hit && hit->kind() == PlannedFault::corrupt) {
    hit->set_bit(static_cast<std::uint32_t>(hit->bit() % (frame_bytes * 8)));
  }
  return hit;
}

std::optional<PlannedFault> FaultEngine::draw(Random& random, PlannedFault::Direction direction,
                                              std::uint64_t message) {
  const v1::RandomFaults& rule = random.rule;
  const auto drawn = [&](Purpose purpose) { return chance(random.stream, message, purpose); };
  if (message < rule.first_message() || (rule.has_max_faults() && random.hits >= rule.max_faults())) return {};
  if (drawn(Purpose::kHit) % rule.mean_messages() != 0) return {};
  ++random.hits;
  PlannedFault fault;
  fault.set_direction(direction);
  fault.set_message(message);
  fault.set_kind(random.kinds[drawn(Purpose::kKind) % random.kinds.size()]);
  const std::uint64_t first = drawn(Purpose::kFirst), second = drawn(Purpose::kSecond);
  switch (fault.kind()) {
    case PlannedFault::delay: fault.set_delay_ms(static_cast<std::uint32_t>(1 + first % rule.max_delay_ms())); break;
    case PlannedFault::corrupt: fault.set_bit(static_cast<std::uint32_t>(first)); break;
    case PlannedFault::slow:
      fault.set_bytes_per_second(rule.bytes_per_second());
      fault.set_messages(rule.slow_messages());
      break;
    case PlannedFault::memory_detected:
    case PlannedFault::memory_silent:
      fault.set_block(static_cast<std::uint32_t>(first));
      fault.set_bit(static_cast<std::uint32_t>(second));
      break;
    default: break;
  }
  return fault;
}

}  // namespace gicube::emu
