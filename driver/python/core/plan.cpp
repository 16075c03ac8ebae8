// The plan steps, and levels of detail.
#include "gicube/plan.h"

#include "call.h"
#include "gicube/level_of_detail.h"
#include "gicube/light_plan.h"

namespace gicube::python {
namespace {

std::vector<TransferFunction> looks_of(py::handle from) {
  return read_as<std::vector<TransferFunction>>(from, "looks");
}

py::object derived(DerivedVolume&& volume) {
  py::dict fields;
  fields["spacing"] = write(volume.spacing);
  fields["range"] = write(volume.range);
  fields["placement"] = write(volume.placement);
  const auto [x, y, z] = volume.dims;
  if (!volume.gradients.empty())
    fields["gradients"] = to_array(std::move(volume.gradients)).attr("reshape")(z, y, x, 3);
  if (!volume.tags.empty()) fields["tags"] = to_array(std::move(volume.tags)).attr("reshape")(z, y, x);
  return volume_of(to_array(std::move(volume.samples)), volume.type, volume.dims, fields);
}

// Of a gicube.Volume that derived() made.
DerivedVolume derived_of(py::handle volume) {
  const VolumeView view = view_of(volume);
  DerivedVolume out;
  out.samples.assign(view.samples.begin(), view.samples.end());
  out.type = view.type;
  out.dims = view.dims;
  out.spacing = view.spacing;
  out.range = view.range.value_or(ValueRange{});
  read(volume.attr("placement"), "coarse.placement", out.placement);
  return out;
}

}  // namespace

void add_plans(py::module_& module) {
  py::class_<Plan> plan(module, "Plan");
  add_properties<Plan>(plan);
  plan.def("view",
           [](const Plan& self, const py::object& original) { return write(self.view(read_as<View>(original, ""))); });
  plan.def("explain", [](const Plan& self) { return write(self.explain()); });
  module.def("make_plan", [](Handle& self, const py::object& volume, const py::object& looks, const py::object& asked,
                             const py::object& progress) {
    auto request = read_as<PlanRequest>(asked, "");
    if (!volume.is_none()) request.volume = view_of(volume);
    const auto functions = looks_of(looks);
    request.looks = functions;
    const Progress told = progress_of(progress);
    const auto board = self.board();
    return without_interpreter([&] { return make_plan(*board, request, told); });
  });
  module.def("load_planned", [](Handle& self, const Plan& made, const py::object& volume, const py::object& looks) {
    const VolumeView from = view_of(volume);
    const auto functions = looks_of(looks);
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
             [](Handle& self, const py::object& lights, const py::object& asked, const py::object& progress) {
               const auto from = read_as<std::vector<Light>>(lights, "lights");
               auto request = read_as<LightPlanRequest>(asked, "");
               request.lights = from;
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
  module.def("level_error", [](const py::object& volume, const py::object& coarse, const py::object& looks) {
    const VolumeView from = view_of(volume);
    const DerivedVolume of = derived_of(coarse);
    const auto functions = looks_of(looks);
    return write(without_interpreter([&] { return level_error(from, of, functions); }));
  });
  module.def("voxels_a_pixel", [](const py::object& view, const py::object& box, const py::object& spacing) {
    return voxels_a_pixel(read_as<View>(view, ""), read_as<VoxelBox>(box, "box"), read_as<Vec3>(spacing, "spacing"));
  });
  module.def("level_for", &level_for);
  module.def("visible_box", [](const py::object& volume, const py::object& looks) {
    return write(visible_box(view_of(volume), looks_of(looks)));
  });
  module.def("colour_at", [](const py::object& look, double value) {
    return write(read_as<TransferFunction>(look, "").colour_at(value));
  });
  module.def("opacity_at", [](const py::object& look, double value) {
    return read_as<TransferFunction>(look, "").opacity_at(value);
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
