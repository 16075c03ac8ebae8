#include "board/saved/saved_records.h"

#include <utility>

#include "encode/camera.h"
#include "encode/lights.h"
#include "encode/look_up_tables.h"

namespace gicube {
namespace {

// Runs a check of arguments, and reports its BadArgument as a CheckpointFault.
void checked(Archive& archive, const char* name, const auto& check_it) {
  if (!archive.loads()) return;
  try {
    check_it();
  } catch (const BadArgument& fault) {
    archive.refuse(std::string(name) + "." + fault.field(), fault.expected(), fault.got());
  }
}

}  // namespace

void state_of(Archive::Record& record, Lamp& lamp) {
  std::uint8_t kind = lamp.light.index() == 3 ? 1 : 0;  // lamps are rectangles or spheres
  record.at_most(kind, 1);
  if (kind == 1) {
    SphereLight sphere = lamp.light.index() == 3 ? std::get<SphereLight>(lamp.light) : SphereLight{};
    record(sphere);
    lamp.light = sphere;
  } else {
    RectangleLight rectangle = lamp.light.index() == 2 ? std::get<RectangleLight>(lamp.light) : RectangleLight{};
    record(rectangle);
    lamp.light = rectangle;
  }
  record(lamp.colour);
}

void state_of(Archive& archive, const char* name, View& view) {
  archive.field(name, [&view](Archive::Record& record) { record(view); });
  // The default view, before any picture, has no direction.
  if (view.eye == view.look_at) return;
  checked(archive, name, [&view] { check(view); });
}

void state_of(Archive& archive, const char* name, Material& material) {
  archive.field(name, [&material](Archive::Record& record) { record(material); });
  checked(archive, name, [&material] { check(material); });
}

void state_of(Archive& archive, const char* name, std::optional<TransferFunction>& function, int tag) {
  bool is_set = function.has_value();
  archive.field(name, [&](Archive::Record& record) {
    record(is_set);
    if (!is_set) return function.reset();
    if (!function) function.emplace();
    record(*function);
  });
  if (function) checked(archive, name, [&] { check(*function, tag); });
}

void state_of(Archive& archive, const char* name, std::optional<CommandResult>& result) {
  bool is_there = result.has_value();
  archive(name, is_there);
  if (!is_there) return result.reset();
  if (!result) result.emplace();
  archive.within(name, [&] {
    archive.at_most("error", result->error, wire::ErrorCode::kForbidden);
    archive("time_ps", result->time_ps);
    archive.bytes("payload", result->payload, 0, ~std::uint64_t{0});
  });
}

}  // namespace gicube
