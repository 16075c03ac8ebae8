// Pairs of elements: rays made by the board's DSP, or here and sent over the bus.
#include <algorithm>
#include <deque>

#include "encode/clear_paths.h"
#include "encode/pairs.h"
#include "state.h"
#include "transport/link_error.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysAtOnce = std::size_t{1} << 18;  // chosen: of a command, or of a batch
constexpr std::size_t kPairsAtOnce = 16'384;               // whose elements and answers fit a payload of 4 MB
constexpr std::size_t kUnderWay = 4;                       // chosen: so that bus and DSP don't wait for one another

std::size_t pairs_at_once(const PairRequest& request, std::size_t payload_bytes) {
  const std::size_t fitting = (payload_bytes - wire::kPairsHeaderBytes) / (wire::kPairBytes + 2 * wire::kElementBytes);
  return std::clamp<std::size_t>(kRaysAtOnce / request.rays, 1, std::min(kPairsAtOnce, fitting));
}

// The pairs that need no ray have their factors, the others are left.
struct Sorted {
  std::vector<PairFactor> factors;
  std::vector<ElementPair> left;
  std::vector<std::size_t> places;  // of those, among all
};

// Without leaping the board would look at voxels whose flags it was told to trust.
Sorted without_clear(std::span<const Element> elements, std::span<const ElementPair> pairs, const PairRequest& request,
                     const LoadedVolume& volume, int block_voxels, const View& sampling) {
  const BlockFlags flags{volume.blocks, block_voxels, volume.flags};
  const bool possible = sampling.leap && std::any_of(flags.empty.begin(), flags.empty.end(), [](auto f) { return f; });
  Sorted sorted;
  sorted.factors.resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (possible) {
      const wire::Element a = to_wire(elements[pairs[i].a]), b = to_wire(elements[pairs[i].b]);
      if (is_clear(a, b, flags, sampling.step)) {
        sorted.factors[i] = clear_factor(a, b, pairs[i].id, request, volume.relative_spacing);
        continue;
      }
    }
    sorted.left.push_back(pairs[i]);
    sorted.places.push_back(i);
  }
  return sorted;
}

}  // namespace

// Commands follow each other to the board while it works.
std::vector<PairFactor> Board::State::pairs_by_board(std::span<const Element> elements,
                                                     std::span<const ElementPair> pairs, const PairRequest& request,
                                                     const Progress& progress) {
  struct Sent {
    std::uint32_t command = 0;
    std::size_t pairs = 0;
  };
  std::deque<Sent> sent;
  std::vector<PairFactor> factors;
  const auto take = [&] {
    const Sent first = sent.front();
    const CommandResult result = device.finish(first.command, {});
    sent.pop_front();
    if (result.error != wire::ErrorCode::kNone) throw_error(result.error, error_text(result.payload));
    if (result.payload.size() != first.pairs * wire::kPairResultBytes) {
      device.give_up("the board returned " + std::to_string(result.payload.size()) + " bytes for " +
                     std::to_string(first.pairs) + " pairs");
    }
    for (std::size_t i = 0; i < first.pairs; ++i) {
      const auto bytes = std::span<const std::uint8_t>(result.payload).subspan(i * wire::kPairResultBytes);
      factors.push_back(from_wire(wire::decode<wire::PairResult>(bytes)));
    }
    if (progress) progress(static_cast<std::uint32_t>(factors.size()), static_cast<std::uint32_t>(pairs.size()));
  };
  const std::size_t max_pairs = pairs_at_once(request, device.agreed().max_payload_bytes);
  try {
    for (std::size_t begin = 0; begin < pairs.size(); begin += max_pairs) {
      const auto part = pairs.subspan(begin, std::min(max_pairs, pairs.size() - begin));
      auto command = wire::share(pairs_command(elements, part, request));
      sent.push_back({device.command(std::move(command)), part.size()});
      if (sent.size() > kUnderWay) take();
    }
    while (!sent.empty()) take();
  } catch (...) {
    for (const Sent& left : sent) device.forget(left.command);
    throw;
  }
  return factors;
}

std::vector<PairFactor> Board::State::pairs_by_host(std::span<const Element> elements,
                                                    std::span<const ElementPair> pairs, const PairRequest& request,
                                                    const Progress& progress) {
  struct Sent {
    Ticket ticket;
    PairRaysMade made;
  };
  std::deque<Sent> sent;
  std::vector<PairFactor> factors;
  const auto take = [&] {
    const Sent first = std::move(sent.front());
    sent.pop_front();
    const RayBatch batch = batches.receive(first.ticket, kNoDeadline);
    const auto part = sum_up(first.made.weights, batch.rays, request.rays);
    factors.insert(factors.end(), part.begin(), part.end());
    if (progress) progress(static_cast<std::uint32_t>(factors.size()), static_cast<std::uint32_t>(pairs.size()));
  };
  const std::size_t max_pairs = pairs_at_once(request, device.agreed().max_payload_bytes);
  for (std::size_t begin = 0; begin < pairs.size(); begin += max_pairs) {
    const auto part = pairs.subspan(begin, std::min(max_pairs, pairs.size() - begin));
    Sent next{{}, make_rays(elements, part, request, loaded("pair_factors()").relative_spacing)};
    const std::span<const HostRay> rays(next.made.rays);
    next.ticket = submit(std::span(&rays, 1), {.type = RayType::kOpacity, .opacity = request.opacity}, {});
    next.made.rays.clear();
    sent.push_back(std::move(next));
    if (sent.size() > kUnderWay) take();
  }
  while (!sent.empty()) take();
  return factors;
}

std::vector<PairFactor> Board::pair_factors(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                            const PairRequest& request, const Progress& progress) {
  const auto lock = state_->begin();
  check(request);
  const LoadedVolume& volume = state_->loaded("pair_factors()");
  for (std::size_t i = 0; i < elements.size(); ++i) check(elements[i], i, volume.dims);
  for (std::size_t i = 0; i < pairs.size(); ++i) check(pairs[i], i, elements.size());
  Sorted sorted = without_clear(elements, pairs, request, volume, state_->info.block_voxels, state_->sampling);
  if (sorted.left.empty()) return std::move(sorted.factors);
  const auto clear = static_cast<std::uint32_t>(pairs.size() - sorted.left.size());
  const Progress given = state_->watched(progress);
  Progress of_all;
  if (given) of_all = [&](std::uint32_t done, std::uint32_t all) { given(done + clear, all + clear); };
  if (request.made == PairRays::kByBoard) state_->set_sampling(state_->sampling);
  const auto found = request.made == PairRays::kByHost ? state_->pairs_by_host(elements, sorted.left, request, of_all)
                                                       : state_->pairs_by_board(elements, sorted.left, request, of_all);
  for (std::size_t i = 0; i < found.size(); ++i) sorted.factors[sorted.places[i]] = found[i];
  return std::move(sorted.factors);
}

}  // namespace gicube
