// Light between pairs of elements. Near pairs are divided into parts. The rays are made by the board's DSP, or here and
// sent over the bus.
#include <fmt/format.h>

#include <algorithm>
#include <deque>

#include "encode/near_pairs.h"
#include "encode/pairs.h"
#include "gicube/wire/command.h"
#include "state.h"

namespace gicube {
namespace {

constexpr std::size_t kRaysAtOnce = std::size_t{1} << 18;   // chosen: per command or batch
constexpr std::size_t kPairsAtOnce = 16'384;                // their elements and results fit a payload of 4 MB
constexpr std::size_t kUnderWay = 4;                        // chosen: commands, so that neither bus nor DSP is idle
constexpr std::size_t kPartsAtOnce = std::size_t{1} << 17;  // chosen: parts of near pairs, some 20 MB of elements

std::size_t pairs_at_once(const PairRequest& request, std::size_t payload_bytes) {
  const std::size_t fitting = (payload_bytes - wire::kPairsHeaderBytes) / (wire::kPairBytes + 2 * wire::kElementBytes);
  return std::clamp<std::size_t>(kRaysAtOnce / request.rays, 1, std::min(kPairsAtOnce, fitting));
}

// Pairs that need no ray have their factors; the others are listed.
struct Sorted {
  std::vector<PairFactor> factors;
  std::vector<ElementPair> left;
  std::vector<std::size_t> places;  // of `left`, among all pairs
};

// Sums up the pairs whose path is clear by the empty flags. With PairRequest::leap off none is: the board must then
// sample all voxels.
Sorted without_clear(std::span<const Element> elements, std::span<const ElementPair> pairs, const PairRequest& request,
                     const LoadedVolume& volume, int block_voxels) {
  const BlockFlags flags{volume.blocks, block_voxels, volume.flags};
  const bool possible = request.leap && std::any_of(flags.empty.begin(), flags.empty.end(), [](auto f) { return f; });
  Sorted sorted;
  sorted.factors.resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (possible) {
      const wire::Element a = to_wire(elements[pairs[i].a]), b = to_wire(elements[pairs[i].b]);
      if (is_clear(a, b, flags, request.step)) {
        sorted.factors[i] = clear_factor(a, b, pairs[i].id, request, volume.relative_spacing);
        continue;
      }
    }
    sorted.left.push_back(pairs[i]);
    sorted.places.push_back(i);
  }
  return sorted;
}

// Sends the pairs in pieces by send(piece), up to kUnderWay ahead of the piece whose factors take(sent) returns, and
// joins all factors. If something throws, forget(sent) is called for each piece under way.
template <typename Send, typename Take, typename Forget>
std::vector<PairFactor> in_pieces(std::span<const ElementPair> pairs, std::size_t max_pairs, const Progress& progress,
                                  const Send& send, const Take& take, const Forget& forget) {
  const auto all = static_cast<std::uint32_t>(pairs.size());
  std::deque<std::invoke_result_t<Send, std::span<const ElementPair>>> sent;
  std::vector<PairFactor> factors;
  try {
    while (!pairs.empty() || !sent.empty()) {
      if (!pairs.empty()) {
        const auto piece = pairs.first(std::min(max_pairs, pairs.size()));
        pairs = pairs.subspan(piece.size());
        sent.push_back(send(piece));
        if (sent.size() <= kUnderWay) continue;
      }
      const std::vector<PairFactor> part = take(sent.front());
      sent.pop_front();
      factors.insert(factors.end(), part.begin(), part.end());
      if (progress) progress(static_cast<std::uint32_t>(factors.size()), all);
    }
  } catch (...) {
    for (const auto& left : sent) forget(left);
    throw;
  }
  return factors;
}

struct SentCommand {
  std::uint32_t command = 0;
  std::size_t pairs = 0;
};

std::vector<PairFactor> factors_of(Device& device, const SentCommand& sent) {
  const CommandResult result = device.finish_or_throw(sent.command);
  if (result.payload.size() != sent.pairs * wire::kPairResultBytes) {
    device.give_up(fmt::format("the board returned {} bytes for {} pairs", result.payload.size(), sent.pairs));
  }
  const std::span<const std::uint8_t> bytes(result.payload);
  std::vector<PairFactor> factors;
  for (std::size_t i = 0; i < sent.pairs; ++i) {
    factors.push_back(from_wire(wire::decode<wire::PairResult>(bytes.subspan(i * wire::kPairResultBytes))));
  }
  return factors;
}

// The parts of several near pairs, as pairs.
struct Parts {
  std::vector<Element> elements;
  std::vector<ElementPair> pairs;

  void add(const Division& division, const Element& a, std::uint32_t id) {
    const auto begin = static_cast<std::uint32_t>(elements.size());
    for (Element element : division.elements) {
      element.origin = element.origin + a.origin;
      elements.push_back(element);
    }
    for (std::uint32_t i = 0; i < division.parts.size(); ++i) {
      const PairPart& part = division.parts[i];
      const std::uint64_t own = i == 0 ? id : wire::split_mix64(id | std::uint64_t{i} << 32);
      pairs.push_back({begin + part.a, begin + part.b, static_cast<std::uint32_t>(own)});
    }
  }
};

}  // namespace

std::vector<PairFactor> BoardState::factors_by_rays(std::span<const Element> elements,
                                                    std::span<const ElementPair> pairs, const PairRequest& request,
                                                    const Progress& progress) {
  const LoadedVolume& of = *volume;
  Sorted sorted = without_clear(elements, pairs, request, of, info.block_voxels);
  const auto clear = static_cast<std::uint32_t>(pairs.size() - sorted.left.size());
  const auto all = static_cast<std::uint32_t>(pairs.size());
  if (sorted.left.empty()) {
    if (progress) progress(all, all);
    return std::move(sorted.factors);
  }
  Progress of_all;
  if (progress) of_all = [&](std::uint32_t done, std::uint32_t) { progress(done + clear, all); };

  const std::size_t max_pairs = pairs_at_once(request, device.agreed().max_payload_bytes);
  std::vector<PairFactor> found;
  const bool board_makes_them = device.agreed().minor >= wire::kPairsMinor && !bricks;
  if (request.made == PairRays::kByBoard && board_makes_them) {
    View sampled;
    sampled.step = request.step, sampled.leap = request.leap;
    set_sampling(sampled);
    const auto send = [&](std::span<const ElementPair> piece) {
      return SentCommand{device.command(wire::share(pairs_command(elements, piece, request))), piece.size()};
    };
    found = in_pieces(
        sorted.left, max_pairs, of_all, send, [&](const SentCommand& sent) { return factors_of(device, sent); },
        [&](const SentCommand& sent) { device.forget(sent.command); });
  } else {
    using SentRays = std::pair<Ticket, std::vector<double>>;  // with their weights
    const auto send = [&](std::span<const ElementPair> piece) -> SentRays {
      PairRaysMade made = make_rays(elements, piece, request, of.relative_spacing, of.dims);
      const std::span<const HostRay> rays(made.rays);
      const RayRequest asked{
          .type = RayType::kOpacity, .opacity = request.opacity, .step = request.step, .leap = request.leap};
      return {submit(std::span(&rays, 1), asked), std::move(made.weights)};
    };
    const auto take = [&](const SentRays& sent) {
      return gicube::sum_up(sent.second, batches.receive(sent.first, kNoDeadline).rays, request.rays);
    };
    found = in_pieces(sorted.left, max_pairs, of_all, send, take, [](const SentRays&) {});
  }
  for (std::size_t i = 0; i < found.size(); ++i) sorted.factors[sorted.places[i]] = found[i];
  return std::move(sorted.factors);
}

Pending<std::vector<PairFactor>> PairIntegrator::start(std::span<const Element> elements,
                                                       std::span<const ElementPair> pairs, const PairRequest& request) {
  return state_->start<std::vector<PairFactor>>(
      [state = state_, elements = std::vector<Element>(elements.begin(), elements.end()),
       pairs = std::vector<ElementPair>(pairs.begin(), pairs.end()), request](const Progress& progress) {
        return PairIntegrator(*state).factors(elements, pairs, request, progress);
      });
}

std::vector<PairFactor> PairIntegrator::factors(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                                const PairRequest& request, const Progress& progress) {
  const auto lock = state_->begin();
  check(request);
  const LoadedVolume& volume = state_->loaded("pair_factors()");
  state_->need_all_blocks("pair_factors()");
  state_->check_drift("request.step", request.step);
  for (std::size_t i = 0; i < elements.size(); ++i) check(elements[i], i, volume.dims);
  for (std::size_t i = 0; i < pairs.size(); ++i) check(pairs[i], i, elements.size());
  const Progress given = state_->watched(progress);
  const auto all = static_cast<std::uint32_t>(pairs.size());

  NearPairs near_pairs(volume.relative_spacing, request.rays);
  std::vector<std::pair<std::size_t, const Division*>> near;  // with their places among all pairs
  std::vector<std::size_t> far_places;
  std::vector<ElementPair> far;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (const Division* division = near_pairs.division_of(elements[pairs[i].a], elements[pairs[i].b])) {
      near.push_back({i, division});
    } else {
      far_places.push_back(i);
      far.push_back(pairs[i]);
    }
  }

  std::vector<PairFactor> factors(pairs.size());
  Progress of_far;
  if (given) of_far = [&](std::uint32_t done, std::uint32_t) { given(done, all); };
  const std::vector<PairFactor> far_factors = state_->factors_by_rays(elements, far, request, of_far);
  for (std::size_t i = 0; i < far.size(); ++i) {
    PairFactor factor = far_factors[i];
    factor.standard_error = error_with_unseen(factor, request.rays);
    factors[far_places[i]] = factor;
  }

  PairRequest of_part = request;
  of_part.rays = near_pairs.rays_per_part();
  for (std::size_t begin = 0, end = 0; begin < near.size(); begin = end) {
    Parts parts;
    for (; end < near.size() && parts.pairs.size() < kPartsAtOnce; ++end) {
      const ElementPair& pair = pairs[near[end].first];
      parts.add(*near[end].second, elements[pair.a], pair.id);
    }
    const std::vector<PairFactor> found = state_->factors_by_rays(parts.elements, parts.pairs, of_part, {});
    std::size_t at = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [place, division] = near[i];
      factors[place] = near_pairs.sum_up(*division, std::span(found).subspan(at, division->parts.size()));
      at += division->parts.size();
    }
    if (given) given(static_cast<std::uint32_t>(far.size() + end), all);
  }
  return factors;
}

}  // namespace gicube
