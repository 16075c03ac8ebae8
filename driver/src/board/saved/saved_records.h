// Lists records in an archive (gicube/archive.h) that have no state() of their own: those of the public headers, and
// results.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "board/saved/fields.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/archive.h"
#include "gicube/material.h"
#include "gicube/view.h"
#include "transport/link.h"

namespace gicube {

inline void state_of(Archive::Record& record, BlockStatistics& of) { record(of.min_density, of.max_density, of.tags); }
// Throw CheckpointFault for values that an application could not have set.
void state_of(Archive& archive, const char* name, View& view);
void state_of(Archive& archive, const char* name, Material& material);
void state_of(Archive& archive, const char* name, std::optional<TransferFunction>& function, int tag);
void state_of(Archive& archive, const char* name, std::optional<CommandResult>& result);

// Lists each value under its key.
template <typename Value, typename Each>
void state_of(Archive& archive, const std::string& name, std::map<std::uint32_t, Value>& values, const Each& each) {
  std::vector<std::uint32_t> keys;
  for (const auto& [key, value] : values) keys.push_back(key);
  archive.list(name, keys);
  if (archive.loads()) values.clear();
  for (const std::uint32_t key : keys) {
    archive.within(
        name + std::to_string(key) + '.', [&] { each(values[key]); }, "");
  }
  archive.expect(values.size() == keys.size(), name, "each once", keys.size());
}

}  // namespace gicube
