// Converts the events of a machine to records for files and plug-ins (gicube/observer.h), and these and the lives of
// pixels to JSON.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "cycle/machine.h"
#include "firmware/pixel_life.h"
#include "gicube/observer.h"
#include "observe/selection.h"
#include "observe/text_file.h"

namespace gicube::emu {

class Events : public Observer {
 public:
  using Take = std::function<void(const gicube_event& event)>;

  Events(const Selection& selection, Take take) : selection_(selection), take_(std::move(take)) {}

  void begins(Cycle now, Machine& machine) override;
  Cycle next(Cycle from) override;
  void see(Cycle now, const Machine& machine) override;
  bool watches(std::uint64_t ray, const wire::Ray& made) override { return selection_.has(ray, made); }
  void happened(const RayEvent& event, const Machine& machine) override;

 private:
  const Selection selection_;
  const Take take_;
  std::uint32_t runs_ = 0;
};

// Return a JSON object in one line. docs/guide/observation.md lists their fields.
std::string to_json(const gicube_event& event);
std::string to_json(const PixelLife& life);

inline constexpr std::uint32_t kEventKinds = GICUBE_EVENT_KINDS;
static_assert(kRayStepNames.size() + 1 == kEventKinds);

}  // namespace gicube::emu
