// gicube-scene: files of volumes, transfer functions and pictures; scenes.
#include "gicube/scene/scene.h"

#include <pybind11/stl/filesystem.h>

#include "call.h"
#include "gicube/scene/image_file.h"
#include "gicube/scene/orientation.h"
#include "gicube/scene/volume_file.h"

namespace gicube::python {
namespace {

using namespace pybind11::literals;
namespace fs = std::filesystem;

// A warning of Python's, which the caller of a function of the package sees; it may be an exception.
void give_warning(const std::string& text) {
  with_interpreter([&] {
    if (PyErr_WarnFormat(PyExc_UserWarning, 2, "%U", decoded(text).ptr()) != 0) throw py::error_already_set();
  });
}

// The fields of a file's or scene's volume other than its samples.
py::dict fields_of(const scene::Volume& volume) {
  py::dict fields;
  fields["spacing"] = write(volume.spacing);
  fields["range"] = write(volume.range);
  fields["source"] = decoded(volume.source);
  fields["world"] = write(volume.placement);
  return fields;
}

// Read-only, of memory of `owner`, which the array keeps alive.
template <typename T>
py::array view_in(const std::vector<T>& values, const py::object& owner) {
  py::array made(py::dtype::of<T>(), {static_cast<py::ssize_t>(values.size())}, values.data(), owner);
  made.attr("setflags")(false);
  return made;
}

py::object volume_in(const py::object& owner) {
  const auto& setup = owner.cast<const scene::SceneSetup&>();
  const auto [x, y, z] = setup.volume.dims;
  if (setup.volume.samples.empty()) throw Error("the scene's voxels were given back: free_voxels()");
  py::dict fields = fields_of(setup.volume);
  if (!setup.tags.empty()) fields["tags"] = view_in(setup.tags, owner).attr("reshape")(z, y, x);
  if (!setup.volume.colours.empty())
    fields["colours"] = view_in(setup.volume.colours, owner).attr("reshape")(z, y, x, 3);
  if (!setup.gradients.empty()) fields["gradients"] = view_in(setup.gradients, owner).attr("reshape")(z, y, x, 3);
  return volume_of(view_in(setup.volume.samples, owner), setup.volume.type, setup.volume.dims, fields);
}

py::object functions_of(const scene::SceneSetup& setup) {
  const ValueRange range = scene::value_range_of(setup.volume);
  py::list out;
  for (const scene::TransferFunctionFile& file : setup.materials) out.append(write(scene::in_values_of(range, file)));
  return out;
}

// A volume whose planes are those of the view, without a copy.
scene::Volume planes_of(const VolumeView& view) {
  scene::Volume volume;
  volume.type = view.type;
  volume.dims = view.dims;
  volume.spacing = view.spacing;
  volume.range = view.range;
  volume.planes = [view](int first, int planes, std::span<std::byte> out) {
    const std::size_t plane = out.size() / static_cast<std::size_t>(planes);
    std::ranges::copy(view.samples.subspan(static_cast<std::size_t>(first) * plane, out.size()), out.begin());
  };
  return volume;
}

void add_files(py::module_& module) {
  module.def("nearest_axes", [](const py::object& directions) {
    return write(scene::nearest_axes(read_as<std::array<Vec3, 3>>(directions, "directions")));
  });
  module.def("read_volume", [](const fs::path& path, const py::object& raw, const std::string& part, bool as_stored,
                               const py::object& nan) {
    scene::VolumeSource source;
    source.file = path;
    source.raw = read_as<std::optional<RawLayout>>(raw, "raw");
    source.part = part;
    source.as_stored = as_stored;
    read(nan, "nan", source.nan);
    // teem keeps its error texts in one place: one reader at a time, for which the interpreter's lock is held.
    scene::Volume volume = scene::read_volume(source);
    py::dict fields = fields_of(volume);
    const auto [x, y, z] = volume.dims;
    if (!volume.colours.empty()) fields["colours"] = to_array(std::move(volume.colours)).attr("reshape")(z, y, x, 3);
    return volume_of(to_array(std::move(volume.samples)), volume.type, volume.dims, fields);
  });
  module.def("write_volume", [](const fs::path& path, const py::object& values, const Dims& dims,
                                const py::object& spacing, const py::object& world) {
    scene::FloatVolume volume;
    volume.dims = dims;
    read(spacing, "spacing", volume.spacing);
    const auto placement = read_as<WorldPlacement>(world, "world");
    volume.origin = placement.origin;
    volume.axes = placement.axes;
    volume.directions = placement.directions;
    volume.values = items_of<float>(values, "values");
    without_interpreter([&] { scene::write_volume(volume, path); });
  });
  module.def("find_transfer_function", [](const std::string& name, const py::object& range) {
    return write(scene::in_values_of(read_as<ValueRange>(range, "range"), scene::find_transfer_function(name)));
  });
  module.def("transfer_function_of", [](const std::string& name, py::handle given) {
    const scene::Volume volume = planes_of(view_of(given));
    const scene::Survey survey = scene::survey_of(volume);
    return write(
        scene::in_values_of(survey, scene::value_range_of(volume), scene::find_transfer_function(name)).function);
  });
  module.def("automatic_look", [](py::handle given) {
    const scene::AutomaticLook look = scene::automatic_look(scene::survey_of(planes_of(view_of(given))));
    return py::make_tuple(write(look.function.function), look.why);
  });
  module.def("presets", [] {
    py::list out;
    for (const scene::Preset& preset : scene::presets()) out.append(py::str(preset.name.data(), preset.name.size()));
    return out;
  });
  module.def("write_image", [](const fs::path& path, const py::array& pixels, const py::object& background) {
    const Image image = image_of(pixels);
    std::optional<scene::Background> under;
    if (!background.is_none()) under.emplace(read_as<Colour>(background, "background"));
    without_interpreter([&] { scene::write_image(image, path, under); });
  });
  module.def("fit_view", [](const py::object& low, const py::object& high, const py::object& spacing,
                            const py::object& view, const py::object& eye, const py::object& look_at,
                            const py::object& up, const std::string& from, const py::object& axes) {
    scene::CameraSettings camera;
    read(eye, "eye", camera.eye);
    read(look_at, "look_at", camera.look_at);
    read(up, "up", camera.up);
    camera.from = from;
    auto out = read_as<View>(view, "");
    camera.fov_degrees = out.fov_degrees;
    if (out.orthographic_height > 0) camera.orthographic_height = out.orthographic_height;
    scene::fit_camera(camera, {read_as<Vec3>(low, "low"), read_as<Vec3>(high, "high")},
                      read_as<Vec3>(spacing, "spacing"), out, read_as<WorldAxes>(axes, "axes"));
    return write(out);
  });
}

}  // namespace

py::object volume_of(const py::array& bytes, SampleType type, const Dims& dims, const py::dict& fields) {
  constexpr const char* kNames[] = {"u1", "u2", "u2", "i2", "f4"};
  const py::object samples = bytes.attr("view")(kNames[static_cast<std::size_t>(type)]);
  return py::module_::import("gicube.volume")
      .attr("Volume")(samples.attr("reshape")(dims[2], dims[1], dims[0]), "sample_type"_a = write(type), **fields);
}

void add_scenes(py::module_& module) {
  scene::set_warning_handler(give_warning);
  add_files(module);
  py::class_<scene::Scene> scene(module, "Scene");
  scene.def("at_time", &scene::at_time);
  scene.def("choose_camera", &scene::choose_camera);
  scene.def("allow_outside", &scene::allow_outside);
  scene.def("set_transfer_function", [](scene::Scene& self, const std::string& name) {
    self.transfer_function = scene::find_transfer_function(name);
  });
  scene.def("set_range", [](scene::Scene& self, double low, double high) { self.range = ValueRange{low, high}; });
  scene.def("get", [](scene::Scene& self, const std::string& target) { return scene::find_parameter(self, target); });
  scene.def("set", [](scene::Scene& self, const std::string& target, double value) {
    scene::find_parameter(self, target) = value;
  });
  scene.def_property_readonly("cameras", [](const scene::Scene& self) {
    std::vector<std::string> names{self.camera.name};
    for (const auto& camera : self.more_cameras) names.push_back(camera.name);
    return write(names);
  });
  scene.def_property(
      "view", [](const scene::Scene& self) { return write(self.view); },
      [](scene::Scene& self, const py::object& view) { read(view, "", self.view); });
  scene.def("set_up", &scene::set_up, py::arg("threads") = 0, py::call_guard<Released>());
  using Path = std::filesystem::path;
  module.def("read_scene", py::overload_cast<const Path&, bool>(&scene::read_scene));
  module.def("parse_scene",
             py::overload_cast<const std::string&, const std::string&, const Path&, bool>(&scene::parse_scene));

  using Setup = scene::SceneSetup;
  py::class_<Setup> setup(module, "SceneSetup");
  setup.def_property_readonly("volume", volume_in);
  setup.def_property_readonly("looks", functions_of);
  add_properties(
      setup,
      std::tuple{std::pair{"materials", &Setup::optics}, std::pair{"scattering_colours", &Setup::scattering_colours},
                 std::pair{"emissions", &Setup::emissions}, std::pair{"light_colours", &Setup::light_colours},
                 std::pair{"shading", &Setup::shading}, std::pair{"lights", &Setup::lights},
                 std::pair{"background", &Setup::background}});
  setup.def_property_readonly("light_has_colours", [](const Setup& self) { return self.lighting.colour_passes; });
  setup.def_property_readonly("is_lit", [](const Setup& self) { return self.lighting.on; });
  setup.def_property_readonly("illumination", [](const Setup& self) { return write(self.lighting.settings); });
  setup.def_property_readonly("view", [](const Setup& self) {
    View view = self.view;
    view.exposure = self.lighting.exposure;
    return write(view);
  });
  setup.def("load", [](const Setup& self, Handle& on, bool own_codebook, const py::object& progress) {
    const Progress told = progress_of(progress);
    const auto board = on.board();
    without_interpreter([&] { scene::load(*board, self, own_codebook, told); });
  });
}

}  // namespace gicube::python
