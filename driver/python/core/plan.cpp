// The plan steps, and levels of detail.
#include "gicube/plan.h"

#include "gicube/level_of_detail.h"
#include "gicube/light_plan.h"
#include "parts.h"
#include "records.h"

namespace gicube::python {
namespace {

template <typename T>
std::vector<T> list_of(py::handle from, const char* field) {
  return read_as<std::vector<T>>(from, field);
}

py::object derived(DerivedVolume&& volume) {
  const std::vector<py::ssize_t> shape{volume.dims[2], volume.dims[1], volume.dims[0]};
  const std::size_t item = bytes_per_sample(volume.type);
  const char* const names[] = {"u1", "u2", "u2", "i2", "f4"};
  const py::dtype type(names[static_cast<std::size_t>(volume.type)]);
  py::dict fields;
  fields["sample_type"] = write(volume.type);
  fields["spacing"] = write(volume.spacing);
  fields["range"] = write(volume.range);
  fields["placement"] = write(volume.placement);
  if (!volume.gradients.empty()) {
    fields["gradients"] = to_array(std::move(volume.gradients), {shape[0], shape[1], shape[2], 3});
  }
  if (!volume.tags.empty()) fields["tags"] = to_array(std::move(volume.tags), shape);
  py::array bytes = to_array(std::move(volume.samples), {shape[0], shape[1], shape[2] * static_cast<py::ssize_t>(item)},
                             py::dtype("u1"));
  return record_class("Volume")(bytes.attr("view")(type), **fields);
}

}  // namespace

void add_plans(py::module_& module) {
  py::class_<Plan> plan(module, "Plan");
  add_properties<Plan>(plan);
  plan.def("view",
           [](const Plan& self, const py::object& original) { return write(self.view(read_as<View>(original, ""))); });
  plan.def("explain", [](const Plan& self) { return write(self.explain()); });
  module.def("make_plan", [](Handle& self, const py::object& volume, const py::object& looks, const py::object& view,
                             double max_error, Picoseconds time_budget, int pilot_pixels, const py::object& progress) {
    PlanRequest request;
    if (!volume.is_none()) request.volume = view_of(volume);
    const auto functions = list_of<TransferFunction>(looks, "looks");
    request.looks = functions;
    request.view = read_as<View>(view, "");
    request.max_error = max_error;
    request.time_budget = time_budget;
    request.pilot_pixels = pilot_pixels;
    const Progress told = progress_of(progress);
    const auto board = self.board();
    return without_interpreter([&] { return make_plan(*board, request, told); });
  });
  module.def("load_planned", [](Handle& self, const Plan& made, const py::object& volume, const py::object& looks) {
    const VolumeView from = view_of(volume);
    const auto functions = list_of<TransferFunction>(looks, "looks");
    const auto board = self.board();
    without_interpreter([&] { load_planned(*board, made, from, functions); });
  });

  py::class_<LightPlan> light(module, "LightPlan");
  add_properties<LightPlan>(light);
  light.def("settings", [](const LightPlan& self, const py::object& original) {
    return write(self.settings(read_as<Illumination>(original, "")));
  });
  light.def("explain", [](const LightPlan& self) { return write(self.explain()); });
  module.def("plan_light",
             [](Handle& self, const py::object& lights, const py::object& settings, const py::object& view, int channel,
                double max_error, Picoseconds time_budget, int max_rays, int pilot_pixels, const py::object& progress) {
               const auto from = list_of<Light>(lights, "lights");
               LightPlanRequest request;
               request.lights = from;
               request.settings = read_as<Illumination>(settings, "");
               request.view = read_as<View>(view, "");
               request.channel = channel;
               request.max_error = max_error;
               request.time_budget = time_budget;
               request.max_rays = max_rays;
               request.pilot_pixels = pilot_pixels;
               const Progress told = progress_of(progress);
               const auto board = self.board();
               return without_interpreter([&] { return plan_light(*board, request, told); });
             });
  module.def("share_of_light", &share_of_light);
  module.def("left_for_picture", &left_for_picture);

  module.def("cropped", [](const py::object& volume, const py::object& box) {
    return derived(cropped(view_of(volume), read_as<VoxelBox>(box, "box")));
  });
  module.def("coarser", [](const py::object& volume, int level) {
    const VolumeView from = view_of(volume);
    return derived(without_interpreter([&] { return coarser(from, level); }));
  });
  module.def("visible_box", [](const py::object& volume, const py::object& looks) {
    return write(visible_box(view_of(volume), list_of<TransferFunction>(looks, "looks")));
  });
  module.def("placed_view", [](const py::object& placement, const py::object& view) {
    return write(read_as<Placement>(placement, "placement").view(read_as<View>(view, "")));
  });
  module.def("placed_look", [](const py::object& placement, const py::object& look, const py::object& range) {
    return write(read_as<Placement>(placement, "placement")
                     .look(read_as<TransferFunction>(look, "look"), read_as<ValueRange>(range, "range")));
  });
}

}  // namespace gicube::python
