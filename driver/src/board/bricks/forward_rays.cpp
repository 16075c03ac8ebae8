// A job of several ranks, each with a board. Rays that wait for blocks of another rank move there, and return to their
// own rank when they end.
//
// The job runs in rounds. Each rank traces until its board has no ray that waits for one of its own blocks. Then all
// ranks exchange rays, and their simulated hosts continue at the latest of their times. The job is done after a round
// in which no rank sent a ray. So simulated time does not depend on the order in which messages arrive. Messages take
// no simulated time.
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "board/state.h"
#include "gicube/wire/forwarded_ray.h"
#include "take_rays.h"

namespace gicube {

namespace {

// The message to one rank in one round.
struct Parcel {
  Picoseconds now = 0;
  std::vector<std::uint8_t> rays{}, ended{};  // records

  std::vector<std::uint8_t> bytes() const {
    std::vector<std::uint8_t> out(16);
    wire::store(std::span(out), 0, now);
    wire::store(std::span(out), 8, std::uint64_t{rays.size()});
    out.insert(out.end(), rays.begin(), rays.end());
    out.insert(out.end(), ended.begin(), ended.end());
    return out;
  }
};

Parcel parcel_of(std::span<const std::uint8_t> bytes) {
  const auto whole = [](std::size_t all, std::size_t record) { return all % record == 0; };
  const std::uint64_t rays = bytes.size() < 16 ? ~std::uint64_t{0} : wire::load<std::uint64_t>(bytes, 8);
  if (rays > bytes.size() - 16 || !whole(rays, wire::kForwardedRayBytes) ||
      !whole(bytes.size() - 16 - rays, wire::kEndedRayBytes)) {
    throw Error("RayExchange::exchange() returned " + std::to_string(bytes.size()) + " bytes that are not rays");
  }
  Parcel out{.now = wire::load<Picoseconds>(bytes, 0)};
  const auto records = bytes.subspan(16);
  const auto middle = static_cast<std::size_t>(rays);
  out.rays.assign(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(middle));
  out.ended.assign(records.begin() + static_cast<std::ptrdiff_t>(middle), records.end());
  return out;
}

std::vector<std::uint32_t> blocks_of(std::span<const wire::WaitingBlock> waiting) {
  std::vector<std::uint32_t> out;
  for (const wire::WaitingBlock& each : waiting) out.push_back(each.block);
  return out;
}

// Marks rays of this rank as the board's own: home 0.
template <typename Ray>
void bring_home(std::vector<std::uint8_t>& records, std::uint16_t own) {
  for (std::size_t at = 0; at < records.size(); at += wire::bytes_of<Ray>()) {
    const auto bytes = std::span(records).subspan(at, wire::bytes_of<Ray>());
    auto ray = wire::decode<Ray>(bytes);
    if (ray.home == own) ray.home = 0;
    wire::encode(ray, bytes);
  }
}

}  // namespace

std::vector<wire::WaitingBlock> BoardState::give_rays(std::vector<std::uint8_t> rays, std::vector<std::uint8_t> ended,
                                                      const wire::GiveRaysHeader& of) {
  std::vector<wire::WaitingBlock> waiting;
  const std::size_t most = device.agreed().max_payload_bytes - wire::kGiveRaysHeaderBytes;
  const auto give = [&](std::span<const std::uint8_t> records, std::size_t record,
                        std::uint32_t wire::GiveRaysHeader::*count) {
    const std::size_t at_once = most / record * record;
    for (std::size_t at = 0; at < records.size(); at += at_once) {
      const auto piece = records.subspan(at, std::min(at_once, records.size() - at));
      wire::GiveRaysHeader header = of;
      header.*count = static_cast<std::uint32_t>(piece.size() / record);
      std::vector<std::uint8_t> command = wire::encoded(header);
      command.insert(command.end(), piece.begin(), piece.end());
      const CommandResult result = device.run(std::move(command), {});
      try {
        waiting = decode_waiting(result.payload, bricks->count()).blocks;
      } catch (const std::out_of_range& error) {
        device.give_up(std::string("a list of waiting rays with a wrong ") + error.what());
      }
    }
  };
  give(ended, wire::kEndedRayBytes, &wire::GiveRaysHeader::ended);
  give(rays, wire::kForwardedRayBytes, &wire::GiveRaysHeader::rays);
  return waiting;
}

bool BoardState::forward(std::span<const wire::WaitingBlock> others, std::vector<wire::WaitingBlock>& waiting,
                         const BrickRun& run) {
  const auto own = static_cast<std::uint16_t>(shared->rank() + 1);
  std::vector<Parcel> out(shared->ranks());
  std::uint64_t sent = 0;
  if (!others.empty()) {
    const std::size_t at_once = blocks_of_take_command(device);
    const std::vector<std::uint32_t> blocks = blocks_of(others);
    for (std::size_t at = 0; at < blocks.size(); at += at_once) {
      const auto piece = std::span(blocks).subspan(at, std::min(at_once, blocks.size() - at));
      take_rays<wire::ForwardedRay>(device, {}, piece, [&](wire::ForwardedRay ray) {
        if (ray.block >= bricks->count()) device.give_up("a ray that waits for a wrong block");
        if (ray.home == 0) ray.home = own;
        wire::append(out[static_cast<std::size_t>(shared->owner(ray.block))].rays, ray);
        ++sent;
      });
    }
  }
  if (std::exchange(may_have_ended, false)) {
    take_rays<wire::EndedRay>(device, {.ended = 1}, {}, [&](const wire::EndedRay& ray) {
      if (ray.home == 0 || ray.home > out.size()) device.give_up("a ray of a wrong home");
      wire::append(out[ray.home - 1u].ended, ray);
      ++sent;
    });
  }
  std::vector<std::vector<std::uint8_t>> messages;
  for (Parcel& parcel : out) {
    parcel.now = device.clock().now();
    messages.push_back(parcel.bytes());
  }
  messages = shared->exchange().exchange(std::move(messages));
  std::vector<std::uint8_t> rays, ended;
  for (const auto& message : messages) {
    const Parcel came = parcel_of(message);
    device.clock().wait_until(came.now);
    rays.insert(rays.end(), came.rays.begin(), came.rays.end());
    ended.insert(ended.end(), came.ended.begin(), came.ended.end());
  }
  bring_home<wire::ForwardedRay>(rays, own);
  bring_home<wire::EndedRay>(ended, own);
  may_have_ended = !rays.empty();
  waiting = give_rays(std::move(rays), std::move(ended), run.of);
  return shared->exchange().sum(sent) > 0;
}

std::vector<std::vector<std::uint8_t>> BoardState::gather(std::vector<std::uint8_t> own) {
  own.resize(own.size() + sizeof(Picoseconds));
  wire::store(std::span(own), own.size() - sizeof(Picoseconds), device.clock().now());
  auto all = shared->gather(own);
  for (auto& each : all) {
    if (each.size() < sizeof(Picoseconds)) throw Error("RayExchange::exchange() returned less than was sent");
    device.clock().wait_until(wire::load<Picoseconds>(each, each.size() - sizeof(Picoseconds)));
    each.resize(each.size() - sizeof(Picoseconds));
  }
  return all;
}

// To be called before rays deposit energy: sets the words of other ranks' blocks to 0 here, so that the sum over all
// ranks is the value of each word.
void BoardState::begin_shared_light() {
  BrickLight& light = bricks->light();
  for (std::size_t block = 0; block < bricks->count(); ++block) {
    if (!shared->is_own(block) && light.may_have(block))
      light.write(device, block, 0, std::vector<std::uint8_t>(light.bytes_of_block()));
  }
}

// To be called after that: the owner of a block adds the other ranks' words, and all ranks get the sum. Energy that
// saturates there moves from `deposited` to `clipped`.
void BoardState::end_shared_light(wire::LightingLedger& ledger) {
  BrickLight& light = bricks->light();
  std::vector<std::vector<std::uint8_t>> out(shared->ranks());
  const auto put = [](std::vector<std::uint8_t>& to, std::size_t block, std::span<const std::uint8_t> words) {
    to.resize(to.size() + 4);
    wire::store(std::span(to), to.size() - 4, static_cast<std::uint32_t>(block));
    to.insert(to.end(), words.begin(), words.end());
  };
  const auto for_each = [&](const std::vector<std::vector<std::uint8_t>>& messages, const auto& use) {
    const std::size_t words = light.bytes_of_block(), each = 4 + words;
    for (const auto& message : messages) {
      if (message.size() % each != 0) throw Error("RayExchange::exchange() returned bytes that are not irradiance");
      for (std::size_t at = 0; at < message.size(); at += each) {
        const auto block = wire::load<std::uint32_t>(message, at);
        if (block >= bricks->count())
          throw Error("RayExchange::exchange() returned irradiance of a block beyond the volume");
        use(block, std::span(message).subspan(at + 4, words));
      }
    }
  };
  for (std::size_t block = 0; block < bricks->count(); ++block) {
    if (shared->is_own(block) || !light.may_have(block)) continue;
    put(out[static_cast<std::size_t>(shared->owner(block))], block, light.read(device, block));
  }
  for_each(shared->exchange().exchange(std::move(out)), [&](std::size_t block, std::span<const std::uint8_t> words) {
    const std::uint64_t clipped = light.add_words(device, block, words);
    ledger.deposited -= clipped;
    ledger.clipped += clipped;
  });
  std::vector<std::uint8_t> own;
  for (std::size_t block = 0; block < bricks->count(); ++block) {
    if (shared->is_own(block) && light.may_have(block)) put(own, block, light.read(device, block));
  }
  for_each(gather(std::move(own)), [&](std::size_t block, std::span<const std::uint8_t> words) {
    if (!shared->is_own(block)) light.write(device, block, 0, words);
  });
  ledger = sum_of_ranks(ledger);
}

wire::LightingLedger BoardState::sum_of_ranks(const wire::LightingLedger& ledger) {
  wire::LightingLedger sum;
  for (const auto& bytes : gather(wire::encoded(ledger))) {
    if (bytes.size() != wire::kLightingLedgerBytes) throw Error("RayExchange::exchange() returned no ledger");
    wire::add(wire::decode<wire::LightingLedger>(bytes), sum);
  }
  return sum;
}

// To be called between commands: deals the blocks again, by the cost of the last ones.
void BoardState::share_anew() {
  const std::uint64_t samples = device.counters().value("pipeline.samples");
  shared->measured(samples - std::exchange(samples_before, samples));
}

}  // namespace gicube
