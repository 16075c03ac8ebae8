// Ray batches in a checkpoint.
#include <utility>

#include "batches.h"
#include "board/saved/saved_records.h"
#include "gicube/wire/ray.h"

namespace gicube {

void Batches::state(Archive& archive) {
  archive("last_ticket", last_ticket_);
  state_of(archive, "tickets", batches_, [&](Batch& batch) { state(archive, batch); });
  if (!archive.loads()) return;
  rays_under_way_ = 0;
  for (const auto& [ticket, batch] : batches_) {
    for (const Part& part : batch.parts) rays_under_way_ += part.result ? 0 : part.rays;
  }
}

void Batches::state(Archive& archive, Batch& batch) const {
  archive("completed", batch.completed);
  archive("rays", batch.rays);
  archive.at_most("type", batch.type, RayType::kBackproject);
  archive("energy_unit", batch.energy_unit);
  state_of(archive, "sampling", batch.sampling);
  archive("towards_eye", batch.towards_eye);
  std::vector<std::uint32_t> commands;
  for (const Part& part : batch.parts) commands.push_back(part.command);
  archive.list("parts", commands);
  if (archive.loads()) {
    batch.parts.assign(commands.size(), {});
    batch.worked_out.reset();
  }
  std::size_t rays = 0;
  for (std::size_t i = 0; i < commands.size(); ++i) {
    Part& part = batch.parts[i];
    part.command = commands[i];
    archive.within("part" + std::to_string(i), [&] {
      archive("rays", part.rays);
      archive.list("units", part.units);
      state_of(archive, "result", part.result);
      // It is sent again, should the board be lost.
      std::vector<std::uint8_t> encoded;
      if (part.encoded) encoded = *part.encoded;
      archive.bytes("encoded", encoded, part.result ? 0 : 1, part.result ? 0 : std::uint64_t{1} << 32);
      if (archive.loads() && !part.result) part.encoded = wire::share(std::move(encoded));
      const bool has_units = part.units.size() == (batch.type == RayType::kIntegral ? part.rays : 0);
      archive.expect(has_units && part.rays <= batch.rays - rays, "rays", "no more than in the batch", part.rays);
      rays += part.rays;
    });
  }
  archive.expect(rays == batch.rays, "rays", "those of its parts", batch.rays);
}

}  // namespace gicube
