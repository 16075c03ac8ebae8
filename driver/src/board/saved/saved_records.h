// How records that know no archive stand in one (gicube/archive.h): the public headers' own, and results.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "encode/volume/voxel_blocks.h"
#include "gicube/archive.h"
#include "gicube/material.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"
#include "transport/link.h"

namespace gicube {

inline void state_of(Archive::Record& record, Vec3& vector) { record(vector.x, vector.y, vector.z); }
inline void state_of(Archive::Record& record, ValueRange& range) { record(range.low, range.high); }
inline void state_of(Archive::Record& record, BlockStatistics& of) { record(of.min_density, of.max_density, of.tags); }
inline void state_of(Archive::Record& record, ColourPoint& point) { record(point.value, point.colour); }
inline void state_of(Archive::Record& record, OpacityPoint& point) { record(point.value, point.opacity); }
inline void state_of(Archive::Record& record, CutPlane& plane) { record(plane.normal, plane.offset); }
void state_of(Archive::Record& record, Shading& shading);
void state_of(Archive::Record& record, Lamp& lamp);
// Throw CheckpointFault if the application could not have given them.
void state_of(Archive& archive, const char* name, View& view);
void state_of(Archive& archive, const char* name, Material& material);
void state_of(Archive& archive, const char* name, std::optional<TransferFunction>& function, int tag);
void state_of(Archive& archive, const char* name, std::optional<CommandResult>& result);

// Each value below its key.
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
