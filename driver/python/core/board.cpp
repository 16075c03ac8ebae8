// Board: sessions, volumes, tables, light, pictures, rays.
#include "gicube/board.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <map>

#include "parts.h"
#include "records.h"

namespace gicube::python {
namespace {

using namespace pybind11::literals;

// Runs Python's handlers of signals that came, on its main thread. Throws what they raise: KeyboardInterrupt for Ctrl-C.
void take_signals() {
  const py::gil_scoped_acquire held;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

// A Python object that the driver may copy and destroy without the interpreter's lock.
std::shared_ptr<py::object> shared(const py::object& object) {
  return {new py::object(object), [](py::object* pointer) {
            const py::gil_scoped_acquire held;
            delete pointer;
          }};
}

OpenOptions options_of(const py::dict& given) {
  OpenOptions options;
  const auto take = [&](const char* name, auto& to) {
    if (given.contains(name)) read(given[name], name, to);
  };
  const auto take_ms = [&](const char* name, std::chrono::milliseconds& to) {
    double seconds = static_cast<double>(to.count()) / 1000;
    take(name, seconds);
    if (!(seconds >= 0 && seconds < 1e9)) refuse(name, "seconds, 0 or more", given[name]);
    to = std::chrono::milliseconds(std::llround(seconds * 1000));
  };
  take_ms("watchdog", options.watchdog);
  take_ms("wait_for_board", options.wait_for_board);
  take("max_rays", options.max_rays);
  take("back_pressure", options.back_pressure);
  take("keep_volume", options.keep_volume);
  take("reopen_attempts", options.reopen_attempts);
  take("force", options.force);
  take("capture", options.capture);
  take("token_file", options.token_file);
  take("ca_file", options.ca_file);
  options.while_waiting = take_signals;
  return options;
}

std::vector<py::ssize_t> shape_of(const Dims& size) { return {size[2], size[1], size[0]}; }

std::size_t voxels_of(const Dims& size) {
  std::size_t out = 1;
  for (const int edge : size) out *= static_cast<std::size_t>(std::max(edge, 0));
  return out;
}

// A box's values, whose array must have its shape.
std::span<const float> values_of(const VoxelBox& box, const py::array& values) {
  const auto out = items_of<float>(values, "values");
  if (out.size() != voxels_of(box.size)) {
    throw BadArgument("values", std::to_string(voxels_of(box.size)) + ", one a voxel of the box",
                      std::to_string(out.size()));
  }
  return out;
}

py::object report_of(const BatchReport& report, const py::object& rays) {
  return record_class("RayBatch")("ticket"_a = report.ticket.id, "completed"_a = report.completed,
                                  "cancelled"_a = report.cancelled, "lighting"_a = write(report.lighting),
                                  "deposits"_a = write(report.deposits), "rays"_a = rays);
}

py::object image_of(Image&& image) {
  return py::module_::import("gicube.image")
      .attr("Image")(to_array(std::move(image.pixels), {image.height, image.width}, dtype_named("PIXEL")));
}

ScatteringRoutine routine_of(const py::object& callable) {
  if (callable.is_none()) return {};
  return [held = shared(callable)](const ScatterEvent& event) {
    const py::gil_scoped_acquire lock;
    py::object told = write(event);
    told.attr("parameters") =
        py::array_t<float>(static_cast<py::ssize_t>(event.parameters.size()), event.parameters.data());
    return read_as<ScatterAnswer>((*held)(told), "answer");
  };
}

py::dict receive(Handle& self, std::uint32_t ticket, const py::array& rays, Picoseconds deadline) {
  const auto space = items_of<TracedRay>(rays, "rays");
  if (!rays.writeable()) throw BadArgument("rays", "an array that can be written to", "one that can't");
  const std::span<TracedRay> to(const_cast<TracedRay*>(space.data()), space.size());
  const auto board = self.board();
  const BatchReport report = without_interpreter([&] { return board->receive({ticket}, to, deadline); });
  py::dict out;
  out["completed"] = report.completed;
  out["cancelled"] = report.cancelled;
  out["lighting"] = write(report.lighting);
  out["deposits"] = write(report.deposits);
  return out;
}

std::uint32_t submit_lines(Handle& self, const py::list& points, const std::vector<std::uint32_t>& ids) {
  std::vector<Polyline> lines;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto line = items_of<double>(py::array(points[i]), "lines[" + std::to_string(i) + "]");
    lines.push_back({ids.at(i), {reinterpret_cast<const Vec3*>(line.data()), line.size() / 3}});
  }
  const auto board = self.board();
  return without_interpreter([&] { return board->submit(std::span<const Polyline>(lines)).id; });
}

// A function of Python for a member of Board: `read`s its arguments, works without the interpreter's lock, and `write`s what comes.
template <typename Result, typename... Arguments>
auto call(Result (Board::*member)(Arguments...)) {
  return [member](Handle& self, std::decay_t<Arguments>... arguments) {
    const auto board = self.board();
    return without_interpreter([&] { return ((*board).*member)(arguments...); });
  };
}

}  // namespace

Handle::Handle(Board board) : board_(std::make_shared<Board>(std::move(board))), process_(::getpid()) {}

Handle::~Handle() {
  if (is_forked()) {
    // Never destroyed: its threads are the parent's.
    [[maybe_unused]] const auto* const kept = std::make_unique<std::shared_ptr<Board>>(std::move(board_)).release();
  } else {
    close();
  }
}

bool Handle::is_forked() const { return process_ != ::getpid(); }

std::shared_ptr<Board> Handle::board() const {
  if (is_forked()) {
    throw Error("this board was opened by the process " + std::to_string(process_) + ": a forked one opens its own");
  }
  if (!board_) throw DeviceLost("the board is closed");
  return board_;
}

void Handle::close() {
  if (is_forked()) return;
  std::shared_ptr<Board> last;
  last.swap(board_);
  const py::gil_scoped_release free;
  last.reset();
}

Progress progress_of(const py::object& callable) {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPause{50};  // chosen: as soon as Ctrl-C needs it
  return [called = callable.is_none() ? nullptr : &callable, next = Clock::now() + kPause](std::uint32_t done,
                                                                                           std::uint32_t all) mutable {
    if (Clock::now() >= next) {
      take_signals();
      next = Clock::now() + kPause;
    }
    if (called == nullptr) return;
    const py::gil_scoped_acquire held;
    (*called)(done, all);
  };
}

VolumeView view_of(py::handle volume) {
  const py::array samples = volume.attr("samples");
  VolumeView view;
  view.type = read_as<SampleType>(volume.attr("sample_type"), "sample_type");
  if (samples.ndim() != 3 || (samples.flags() & py::array::c_style) == 0 ||
      static_cast<std::size_t>(samples.itemsize()) != bytes_per_sample(view.type)) {
    refuse("samples", "a contiguous array of (z, y, x)", samples.attr("shape"));
  }
  view.samples = {static_cast<const std::byte*>(samples.data()), static_cast<std::size_t>(samples.nbytes())};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    view.dims[axis] = static_cast<int>(samples.shape(static_cast<py::ssize_t>(2 - axis)));
  }
  read(volume.attr("spacing"), "spacing", view.spacing);
  read(volume.attr("range"), "range", view.range);
  read(volume.attr("find_gradients"), "find_gradients", view.find_gradients);
  if (const py::object gradients = volume.attr("gradients"); !gradients.is_none()) {
    view.gradients = items_of<float>(gradients, "gradients");
  }
  if (const py::object tags = volume.attr("tags"); !tags.is_none()) view.tags = items_of<std::uint8_t>(tags, "tags");
  return view;
}

void add_board(py::module_& module) {
  py::class_<Handle> type(module, "Board");
  type.def(py::init([](const std::string& uri, const py::dict& given) {
    const OpenOptions options = options_of(given);
    return without_interpreter([&] { return std::make_unique<Handle>(Board::open(uri, options)); });
  }));
  type.def("close", &Handle::close);
  type.def_property_readonly("info", [](Handle& self) { return write(self.board()->info()); });
  type.def_property_readonly("now", [](Handle& self) { return self.board()->now(); });
  type.def("reopen", [](Handle& self) {
    const auto board = self.board();
    return write(without_interpreter([&] { return board->reopen(); }));
  });

  // Volume.
  type.def("load_volume", [](Handle& self, const py::object& volume, const py::object& progress) {
    const VolumeView view = view_of(volume);
    const Progress told = progress_of(progress);
    const auto board = self.board();
    without_interpreter([&] { board->load_volume(view, told); });
  });
  type.def("read_volume", [](Handle& self, const py::object& where) {
    const auto box = read_as<VoxelBox>(where, "box");
    const auto board = self.board();
    return to_array(without_interpreter([&] { return board->read_volume(box); }), shape_of(box.size));
  });
  type.def("write_volume", [](Handle& self, const py::object& where, const py::array& values) {
    const auto box = read_as<VoxelBox>(where, "box");
    const auto from = values_of(box, values);
    const auto board = self.board();
    without_interpreter([&] { board->write_volume(box, from); });
  });
  type.def("dims", [](Handle& self) {  // of the volume
    const auto board = self.board();
    return write(without_interpreter([&] { return board->dims(); }));
  });
  type.def("verify_volume", [](Handle& self) { return write(call(&Board::verify_volume)(self)); });
  type.def("value_range", [](Handle& self) { return write(self.board()->value_range()); });
  type.def("set_empty_flags", [](Handle& self, const py::array& flags) {
    const auto from = items_of<std::uint8_t>(flags, "flags");
    const auto board = self.board();
    without_interpreter([&] { board->set_empty_flags(from); });
  });
  type.def("empty_flags", [](Handle& self) {
    const auto board = self.board();
    const Dims blocks = without_interpreter([&] { return board->blocks(); });
    return to_array(without_interpreter([&] { return board->empty_flags(); }), shape_of(blocks));
  });
  type.def("set_gradient_codebook", [](Handle& self, const py::array& codebook) {
    const auto from = items_of<double>(codebook, "codebook");
    std::vector<Vec3> directions;
    for (std::size_t i = 0; i + 2 < from.size(); i += 3) directions.push_back({from[i], from[i + 1], from[i + 2]});
    const auto board = self.board();
    without_interpreter([&] { board->set_gradient_codebook(directions); });
  });

  // Looks.
  type.def("set_transfer_function", [](Handle& self, const py::object& function, int tag) {
    const auto from = read_as<TransferFunction>(function, "function");
    const auto board = self.board();
    without_interpreter([&] { board->set_transfer_function(from, tag); });
  });
  type.def("set_shading", [](Handle& self, const py::object& shading) {
    const auto from = read_as<Shading>(shading, "shading");
    const auto board = self.board();
    without_interpreter([&] { board->set_shading(from); });
  });
  type.def("set_material", [](Handle& self, const py::object& material, int tag) {
    const auto from = read_as<Material>(material, "material");
    const auto board = self.board();
    without_interpreter([&] { board->set_material(from, tag); });
  });
  type.def("set_scattering_routine", [](Handle& self, const py::object& routine, Picoseconds time_per_ray) {
    ScatteringRoutine made = routine_of(routine);
    const auto board = self.board();
    without_interpreter([&] { board->set_scattering_routine(std::move(made), time_per_ray); });
  });

  // Light.
  type.def("illuminate",
           [](Handle& self, const py::object& lights, const py::object& settings, const py::object& progress) {
             const auto from = read_as<std::vector<Light>>(lights, "lights");
             const auto how = read_as<Illumination>(settings, "");
             const Progress told = progress_of(progress);
             const auto board = self.board();
             return write(without_interpreter([&] { return board->illuminate(from, how, told); }));
           });
  type.def("read_irradiance", [](Handle& self, const py::object& where) {
    const auto box = read_as<VoxelBox>(where, "box");
    const auto board = self.board();
    return to_array(without_interpreter([&] { return board->read_irradiance(box); }), shape_of(box.size));
  });
  type.def("write_irradiance", [](Handle& self, const py::object& where, const py::array& values) {
    const auto box = read_as<VoxelBox>(where, "box");
    const auto from = values_of(box, values);
    const auto board = self.board();
    without_interpreter([&] { board->write_irradiance(box, from); });
  });
  type.def("clear_irradiance", call(&Board::clear_irradiance));
  type.def("clear_sums", call(&Board::clear_sums));
  type.def("read_sums", [](Handle& self, const py::object& where) {
    const auto box = read_as<VoxelBox>(where, "box");
    const auto board = self.board();
    return to_array(without_interpreter([&] { return board->read_sums(box); }), shape_of(box.size));
  });

  // Pictures.
  type.def("render_to_framebuffer", [](Handle& self, const py::object& view, const py::object& progress) {
    const auto from = read_as<View>(view, "");
    const Progress told = progress_of(progress);
    const auto board = self.board();
    without_interpreter([&] { board->render_to_framebuffer(from, told); });
  });
  type.def("read_framebuffer", [](Handle& self) {
    const auto board = self.board();
    return image_of(without_interpreter([&] { return board->read_framebuffer(); }));
  });

  // Rays.
  type.def("submit", [](Handle& self, const py::array& rays, const py::object& request) {
    const auto from = items_of<HostRay>(rays, "rays");
    const auto how = read_as<RayRequest>(request, "");
    const auto board = self.board();
    return without_interpreter([&] { return board->submit(from, how).id; });
  });
  type.def("submit_lines", submit_lines);
  type.def("receive", receive);
  type.def("poll", [](Handle& self) {
    const auto board = self.board();
    auto batches = without_interpreter([&] { return board->poll(); });
    py::list out;
    for (RayBatch& batch : batches) {
      const auto count = static_cast<py::ssize_t>(batch.rays.size());
      out.append(report_of(batch, to_array(std::move(batch.rays), {count}, dtype_named("TRACED_RAY"))));
    }
    return out;
  });
  type.def("cancel", [](Handle& self, std::uint32_t ticket) {
    const auto board = self.board();
    return without_interpreter([&] { return board->cancel({ticket}); });
  });
  type.def("descriptor", [](Handle& self, std::uint32_t ticket) {
    const auto board = self.board();
    return without_interpreter([&] { return board->descriptor({ticket}); });
  });
  type.def("pair_factors", [](Handle& self, const py::array& elements, const py::array& pairs,
                              const py::object& request, const py::object& progress) {
    const auto from = items_of<Element>(elements, "elements");
    const auto which = items_of<ElementPair>(pairs, "pairs");
    const auto how = read_as<PairRequest>(request, "");
    const Progress told = progress_of(progress);
    const auto board = self.board();
    auto factors = without_interpreter([&] { return board->pair_factors(from, which, how, told); });
    const auto count = static_cast<py::ssize_t>(factors.size());
    return to_array(std::move(factors), {count}, dtype_named("PAIR_FACTOR"));
  });

  // Time and counters.
  type.def("host_compute", call(&Board::host_compute));
  type.def("set_time_limit", call(&Board::set_time_limit));
  type.def("counters", [](Handle& self) {
    const auto board = self.board();
    const Counters counters = without_interpreter([&] { return board->counters(); });
    py::list out;
    for (const Counter& each : counters.list()) out.append(py::make_tuple(each.name, each.unit, each.value));
    return out;
  });

  module.def("clip_to_volume", [](const py::array& rays, const Dims& dims) {
    std::vector<HostRay> kept;
    for (const HostRay& ray : items_of<HostRay>(rays, "rays")) {
      if (const auto part = clip_to_volume(ray, dims)) kept.push_back(*part);
    }
    const auto count = static_cast<py::ssize_t>(kept.size());
    return to_array(std::move(kept), {count}, dtype_named("RAY"));
  });
  module.def("standard_error", [](const py::object& report, double irradiance) {
    return standard_error(read_as<LightingReport>(report, "report"), irradiance);
  });
}

}  // namespace gicube::python
