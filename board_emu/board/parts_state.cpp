// Checkpoint fields and counters of a board.
#include <algorithm>
#include <string>
#include <utility>

#include "board/parts.h"

namespace gicube::emu {

void Board::Parts::state(Archive& archive, bool with_level) {
  archive("registers", registers);
  archive("pci", pci);
  archive("commands", card);
  archive("timeline", timeline);
  archive("next_transaction", next_transaction);
  archive.expect(!timeline.has_from(next_transaction), "next_transaction", "a number that none has", next_transaction);
  std::vector<std::uint64_t> ids;  // ids of commands
  for (const auto& [id, completion] : under_way) ids.push_back(id);
  std::ranges::sort(ids);
  archive.list("under_way", ids);
  for (const std::uint64_t id : ids) {
    Completion& completion = under_way[id];
    archive.within("command" + std::to_string(id), [&] {
      archive("ticket", completion.ticket);
      archive.at_most("error", completion.error, wire::ErrorCode::kForbidden);
      archive("can_be_cancelled", completion.can_be_cancelled);
      archive.bytes("payload", completion.payload, 0, ~std::uint64_t{0});
      if (!archive.loads()) return;
      archive.expect(timeline.has_watched(id) && id < next_transaction, "ticket", "a command that is under way",
                     completion.ticket);
      archive.expect(tickets.emplace(completion.ticket, id).second, "ticket", "each once", completion.ticket);
      result_bytes += completion.payload.capacity();
    });
  }
  bool in_command = carried.has_value();
  archive("in_command", in_command);
  if (in_command) {
    if (archive.loads()) carried.emplace(Carried{}).header.type = wire::FrameType::kCommand;
    archive.field("carried", [this](Archive::Record& record) {
      record(carried->header.id);
      record.at_most(carried->header.time_ps, kEndOfTime);
    });
    std::vector<std::uint8_t> payload(carried->payload.begin(), carried->payload.end());
    archive.bytes("carried_payload", payload, 0, ~std::uint64_t{0});
    if (archive.loads()) carried->payload = carried->loaded = std::move(payload);
    archive.expect(!tickets.contains(carried->header.id), "carried", "a ticket of its own", carried->header.id);
  }
  archive("power", power);
  if (with_level) {
    archive.within("level", [&] { level->state(archive, card.aperture.volume().blocks()); });
    archive.expect(in_command || !level->in_run(), "level.in_run", "0 without a command", 1);
  }
}

std::vector<wire::Counter> Board::Parts::count() const {
  std::vector<wire::Counter> list;
  for (const BusDirection direction : {BusDirection::kDown, BusDirection::kUp}) {
    const BusCounters& bus = timeline.bus().counters(direction);
    const std::string prefix = direction == BusDirection::kDown ? "bus.down." : "bus.up.";
    list.push_back({prefix + "bytes", "byte", bus.bytes});
    list.push_back({prefix + "transfers", "transfer", bus.transfers});
    list.push_back({prefix + "bursts", "burst", bus.bursts});
    list.push_back({prefix + "busy_ps", "ps", bus.busy_ps});
    list.push_back({prefix + "wait_ps", "ps", bus.wait_ps});
  }
  for (std::size_t i = 0; i < kCargoNames.size(); ++i) {
    const CargoCounters& cargo = timeline.bus().counters(static_cast<Cargo>(i));
    const std::string prefix = std::string("bus.") + kCargoNames[i] + '.';
    list.push_back({prefix + "bytes", "byte", cargo.bytes});
    list.push_back({prefix + "transfers", "transfer", cargo.transfers});
    list.push_back({prefix + "time_ps", "ps", cargo.time_ps});
  }
  list.push_back({"dsp.busy_ps", "ps", timeline.dsp_busy_ps()});
  list.push_back({"dsp.host_bus_wait_ps", "ps", timeline.host_bus_wait_ps()});
  card.count(list);
  return list;
}

}  // namespace gicube::emu
