// The plan steps, and levels of detail.
#include "gicube/plan.h"

#include "call.h"

namespace gicube::python {

py::object given_back(DerivedVolume&& volume) {
  py::dict fields;
  fields["spacing"] = write(volume.spacing);
  fields["range"] = write(volume.range);
  fields["placement"] = write(volume.placement);
  const auto [x, y, z] = volume.dims;
  if (!volume.gradients.empty())
    fields["gradients"] = to_array(std::move(volume.gradients)).attr("reshape")(z, y, x, 3);
  if (!volume.colours.empty()) fields["colours"] = to_array(std::move(volume.colours)).attr("reshape")(z, y, x, 3);
  if (!volume.tags.empty()) fields["tags"] = to_array(std::move(volume.tags)).attr("reshape")(z, y, x);
  return volume_of(to_array(std::move(volume.samples)), volume.type, volume.dims, fields);
}

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

void add_plans(py::module_& module) {
  py::class_<Plan> plan(module, "Plan");
  add_properties(plan, Record<Plan>::fields());
  plan.def("view", call(&Plan::view, ""));
  plan.def("explain", call(&Plan::explain));
  module.def("make_plan", [](const Handle& self, const py::object& volume, const py::object& looks,
                             const py::object& asked, const py::object& progress) {
    auto request = read_as<PlanRequest>(asked, "");
    if (!volume.is_none()) request.volume = view_of(volume);
    const auto functions = read_as<std::vector<TransferFunction>>(looks, "looks");
    request.looks = functions;
    const Progress told = progress_of(progress);
    const auto board = self.board();
    return without_interpreter([&] { return make_plan(*board, request, told); });
  });
  module.def("load_planned", call(&load_planned, "", "", "volume", "looks"));

  py::class_<LightPlan> light(module, "LightPlan");
  add_properties(light, Record<LightPlan>::fields());
  light.def("settings", call(&LightPlan::settings, ""));
  light.def("explain", call(&LightPlan::explain));
  module.def("plan_light",
             [](const Handle& self, const py::object& lights, const py::object& asked, const py::object& progress) {
               const auto from = read_as<std::vector<Light>>(lights, "lights");
               auto request = read_as<LightPlanRequest>(asked, "");
               request.lights = from;
               const Progress told = progress_of(progress);
               const auto board = self.board();
               return without_interpreter([&] { return plan_light(*board, request, told); });
             });
  module.def("share_of_light", call(&share_of_light, "max_error"));
  module.def("left_for_picture", call(&left_for_picture, "max_error", ""));

  module.def("cropped", call(&cropped, "volume", "box"));
  module.def("coarser", call(&coarser, "volume", "level"));
  module.def("level_error", call(&level_error, "volume", "coarse", "looks"));
  module.def("voxels_a_pixel", call(&voxels_a_pixel, "", "box", "spacing"));
  module.def("level_for", call(&level_for, "voxels_a_pixel"));
  module.def("visible_box", call(&visible_box, "volume", "looks"));
  module.def("colour_at", call(&TransferFunction::colour_at, "value"));
  module.def("opacity_at", call(&TransferFunction::opacity_at, "value"));
  module.def("placed_view", call(&Placement::view, ""));
  module.def("placed_look", call(&Placement::look, "look", "range"));
}

}  // namespace gicube::python
