// Board: sessions, volumes, tables, light, pictures, rays.
#include "gicube/board.h"
#include "gicube/ray_exchange.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>

#include "call.h"

namespace gicube::python {

void take_signals() {
  with_interpreter([] {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  });
}

namespace {

using namespace pybind11::literals;

// A Python object that the driver may copy and destroy without the interpreter's lock.
std::shared_ptr<py::object> shared(py::handle object) {
  return {new py::object(py::reinterpret_borrow<py::object>(object)),
          [](py::object* pointer) { with_interpreter([pointer] { delete pointer; }); }};
}

py::object report_of(const BatchReport& report, const py::object& rays) {
  return record_class<RayBatch>()("ticket"_a = report.ticket.id, "completed"_a = report.completed,
                                  "cancelled"_a = report.cancelled, "lighting"_a = write(report.lighting),
                                  "deposits"_a = write(report.deposits), "rays"_a = rays);
}

// Into an array of the caller's.
py::object receive(Handle& self, std::uint32_t ticket, const py::array& out, Picoseconds deadline) {
  const auto space = items_of<TracedRay>(out, "out");
  if (!out.writeable()) throw BadArgument("out", "an array that can be written to", "one that can't");
  const std::span<TracedRay> to(const_cast<TracedRay*>(space.data()), space.size());
  const auto board = self.board();
  const BatchReport report = without_interpreter([&] { return board->receive({ticket}, to, deadline); });
  clear_padding(to);
  return report_of(report, report.cancelled ? py::object(out[py::slice(0, 0, 1)]) : py::object(out));
}

// One batch of rays that lie in several arrays.
std::uint32_t submit(Handle& self, const py::list& arrays, const py::object& request) {
  std::vector<std::span<const HostRay>> places;
  for (const py::handle each : arrays) places.push_back(items_of<HostRay>(each, "rays"));
  const auto how = read_as<RayRequest>(request, "");
  const auto board = self.board();
  return without_interpreter([&] { return board->submit(places, how).id; });
}

// A Pending of the driver. `kept`: the arrays that its call reads meanwhile.
struct Started {
  std::shared_ptr<PendingCall> call;
  std::function<py::object(Picoseconds)> result;
  py::object kept;

  bool wait(const py::object& timeout) const {
    using std::chrono::milliseconds;
    const auto longest = timeout.is_none() ? milliseconds::max() : read_as<milliseconds>(timeout, "timeout");
    constexpr milliseconds kPause{50};  // chosen: as soon as Ctrl-C needs it
    for (milliseconds waited{0};; waited += kPause) {
      if (without_interpreter([&] { return call->wait(std::min(kPause, longest - waited)); })) return true;
      if (longest - waited <= kPause) return false;
      take_signals();
    }
  }
};

template <typename T>
Started started(Pending<T>&& pending, py::object kept = py::none()) {
  auto call = std::make_shared<Pending<T>>(std::move(pending));
  const auto result = [call](Picoseconds deadline) -> py::object {
    if constexpr (std::is_void_v<T>) {
      without_interpreter([&] { call->get(deadline); });
      return py::none();
    } else {
      return given_back(without_interpreter([&] { return call->get(deadline); }));
    }
  };
  return {call, result, std::move(kept)};
}

void add_started(py::module_& module, py::class_<Handle>& board) {
  py::class_<Started> type(module, "Started");
  type.def("wait", &Started::wait);
  type.def("result", [](const Started& self, Picoseconds deadline) {
    self.wait(py::none());
    return self.result(deadline);
  });
  type.def("cancel", [](const Started& self) { return without_interpreter([&] { return self.call->cancel(); }); });
  type.def("descriptor", [](const Started& self) { return self.call->descriptor(); });
  type.def("progress", [](const Started& self) {
    const PendingProgress progress = self.call->progress();
    return py::make_tuple(progress.done, progress.all);
  });
  board.def("start_load", [](const Handle& self, const py::object& volume) {
    const VolumeView view = view_of(volume);
    return started(self.board()->volume().start_load(view), volume);
  });
  board.def("start_load_stream", [](const Handle& self, const py::object& volume) {
    return started(self.board()->volume().start_load(stream_of(volume)), volume);
  });
  board.def("start_render", [](const Handle& self, const py::object& view) {
    return started(self.board()->renderer().start(read_as<View>(view, "")));
  });
  board.def("start_illuminate", [](const Handle& self, const py::object& lights, const py::object& settings) {
    const auto all = read_as<std::vector<Light>>(lights, "lights");
    return started(self.board()->light().start(all, read_as<Illumination>(settings, "")));
  });
  board.def("start_pair_factors",
            [](const Handle& self, const py::object& elements, const py::object& pairs, const py::object& request) {
              const auto all = items_of<Element>(elements, "elements");
              const auto of = items_of<ElementPair>(pairs, "pairs");
              return started(self.board()->pairs().start(all, of, read_as<PairRequest>(request, "")));
            });
  board.def("start_rays", [](const Handle& self, const py::object& rays, const py::object& request) {
    const auto all = items_of<HostRay>(rays, "rays");
    const auto how = read_as<RayRequest>(request, "");
    const auto of = self.board();
    return started(without_interpreter([&] { return of->rays().start(all, how); }));
  });
}

// A rank of a job whose exchange is an object of Python.
class PythonExchange : public RayExchange {
 public:
  explicit PythonExchange(py::handle object)
      : object_(shared(object)),
        rank_(read_as<int>(object.attr("rank"), "exchange.rank")),
        ranks_(read_as<int>(object.attr("ranks"), "exchange.ranks")) {}

  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  std::vector<std::vector<std::uint8_t>> exchange(std::vector<std::vector<std::uint8_t>> to) override {
    return with_interpreter([&] {
      py::list parts;
      for (const auto& part : to) parts.append(py::bytes(reinterpret_cast<const char*>(part.data()), part.size()));
      const py::list came(object_->attr("exchange")(parts));
      std::vector<std::vector<std::uint8_t>> out;
      for (const py::handle each : came) {
        if (!py::isinstance<py::bytes>(each)) refuse("exchange()", "a list of bytes", each);
        const auto bytes = static_cast<std::string_view>(py::reinterpret_borrow<py::bytes>(each));
        out.emplace_back(bytes.begin(), bytes.end());
      }
      if (out.size() != static_cast<std::size_t>(ranks_)) {
        refuse("exchange()", "one bytes of each of " + std::to_string(ranks_) + " ranks", py::int_(out.size()));
      }
      return out;
    });
  }
  std::uint64_t sum(std::uint64_t value) override {
    return with_interpreter([&] { return read_as<std::uint64_t>(object_->attr("sum")(value), "sum()"); });
  }

 private:
  decltype(shared(py::handle())) object_;
  int rank_, ranks_;
};

}  // namespace

Image image_of(const py::array& pixels) {
  const auto from = items_of<Pixel>(pixels, "pixels");
  return {static_cast<int>(pixels.shape(1)), static_cast<int>(pixels.shape(0)), {from.begin(), from.end()}};
}

py::object given_back(Image&& image) {
  const py::array pixels = to_array(std::move(image.pixels));
  return py::module_::import("gicube.image").attr("Image")(pixels.attr("reshape")(image.height, image.width));
}

py::object given_back(RayBatch&& batch) { return report_of(batch, to_array(std::move(batch.rays))); }

py::object given_back(std::vector<RayBatch>&& batches) {
  py::list out;
  for (RayBatch& batch : batches) out.append(given_back(std::move(batch)));
  return out;
}

py::object given_back(const Counters& counters) {
  py::list out;
  for (const Counter& each : counters.list()) out.append(py::make_tuple(each.name, each.unit, each.value));
  return out;
}

ScatteringRoutine routine_of(py::handle callable) {
  if (callable.is_none()) return {};
  return [held = shared(callable)](const ScatterEvent& event) {
    return with_interpreter([&] {
      py::object told = write(event);
      told.attr("parameters") =
          py::array_t<float>(static_cast<py::ssize_t>(event.parameters.size()), event.parameters.data());
      return read_as<ScatterAnswer>((*held)(told), "answer");
    });
  };
}

Progress progress_of(py::handle callable) {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPause{50};  // chosen: as soon as Ctrl-C needs it
  return [callable, next = Clock::now() + kPause](std::uint32_t done, std::uint32_t all) mutable {
    if (Clock::now() >= next) {
      take_signals();
      next = Clock::now() + kPause;
    }
    if (!callable.is_none()) with_interpreter([&] { callable(done, all); });
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
  const py::object gradients = volume.attr("gradients");
  if (!gradients.is_none()) view.gradients = items_of<float>(gradients, "gradients");
  if (const py::object colours = volume.attr("colours"); !colours.is_none()) {
    view.colours = items_of<std::uint8_t>(colours, "colours");
  }
  if (const py::object tags = volume.attr("tags"); !tags.is_none()) view.tags = items_of<std::uint8_t>(tags, "tags");
  return view;
}

VolumeStream stream_of(py::handle volume) {
  VolumeStream stream;
  stream.type = read_as<SampleType>(volume.attr("sample_type"), "sample_type");
  read(volume.attr("dims"), "dims", stream.dims);
  read(volume.attr("spacing"), "spacing", stream.spacing);
  read(volume.attr("range"), "range", stream.range);
  read(volume.attr("find_gradients"), "find_gradients", stream.find_gradients);
  const auto reader = [volume](const char* method) {
    return [volume, method](int first, int planes, std::span<std::byte> out) {
      with_interpreter([&] {
        const py::array made = volume.attr(method)(first, planes);
        if (static_cast<std::size_t>(made.nbytes()) != out.size())
          refuse("sample_type", "that of the planes", made.dtype());
        std::memcpy(out.data(), made.data(), out.size());
      });
    };
  };
  stream.read = reader("_planes");
  if (!volume.attr("read_colours").is_none()) stream.read_colours = reader("_colours");
  return stream;
}

void add_board(py::module_& module) {
  py::class_<Handle> type(module, "Board");
  type.def(py::init([](const std::string& uri, const py::dict& given) {
    auto options = read_as<OpenOptions>(given, "");
    options.while_waiting = take_signals;
    return without_interpreter(
        [&] { return std::make_unique<Handle>(std::make_shared<Board>(Board::open(uri, options))); });
  }));
  type.def("close", &Handle::close);
  type.def("close_if_idle", &Handle::close_if_idle);
  type.def_property_readonly("info", call(&Board::info));
  type.def_property_readonly("now", call(&Board::now));
  type.def("reopen", call(&Board::reopen));

  using SaveFile = void (Board::*)(const std::string&);
  using RestoreBytes = void (Board::*)(std::span<const std::byte>);
  type.def("save", call(static_cast<std::vector<std::byte> (Board::*)()>(&Board::save)));
  type.def("save_to", call(static_cast<SaveFile>(&Board::save), "file"));
  type.def("restore", call(static_cast<RestoreBytes>(&Board::restore), "checkpoint"));
  type.def("restore_from", call(static_cast<SaveFile>(&Board::restore), "file"));

  using Load = void (Board::*)(const VolumeView&, const Progress&);
  type.def("load_volume", call(static_cast<Load>(&Board::load_volume), "volume", "progress"));
  using LoadStream = void (Board::*)(const VolumeStream&, const Progress&);
  type.def("load_stream", call(static_cast<LoadStream>(&Board::load_volume), "volume", "progress"));
  type.def("read_volume", call(&Board::read_volume, "box"));
  type.def("write_volume", call(&Board::write_volume, "box", "values"));
  type.def("verify_volume", call(&Board::verify_volume));
  type.def("dims", call(&Board::dims));
  type.def("value_range", call(&Board::value_range));
  type.def("blocks", call(&Board::blocks));
  type.def("empty_flags", call(&Board::empty_flags));
  type.def("set_empty_flags", call(&Board::set_empty_flags, "flags"));
  type.def("set_gradient_codebook", call(&Board::set_gradient_codebook, "directions"));

  type.def("set_transfer_function", call(&Board::set_transfer_function, "function", "tag"));
  type.def("set_shading", call(&Board::set_shading, "shading"));
  type.def("set_material", call(&Board::set_material, "material", "tag"));
  type.def("set_scattering_routine", call(&Board::set_scattering_routine, "routine", "time_per_ray"));

  type.def("illuminate", call(&Board::illuminate, "lights", "", "progress"));
  type.def("read_irradiance",
           call(static_cast<std::vector<float> (Board::*)(const VoxelBox&)>(&Board::read_irradiance), "box"));
  type.def("write_irradiance", call(&Board::write_irradiance, "box", "values"));
  type.def("clear_irradiance", call(&Board::clear_irradiance, "unit"));
  type.def("clear_sums", call(&Board::clear_sums, "unit"));
  type.def("read_sums", call(&Board::read_sums, "box"));

  type.def("render_to_framebuffer", call(&Board::render_to_framebuffer, "", "progress"));
  type.def("read_framebuffer", call(&Board::read_framebuffer));
  type.def("why_invisible",
           [](const Handle& self, const py::array& pixels) { return self.board()->why_invisible(image_of(pixels)); });

  type.def("submit", submit);
  type.def("receive", receive);
  type.def("poll", call(&Board::poll));
  type.def("cancel", call(&Board::cancel, "ticket"));
  type.def("descriptor", call(&Board::descriptor, "ticket"));
  type.def("pair_factors", call(&Board::pair_factors, "elements", "pairs", "", "progress"));

  add_started(module, type);

  type.def("host_compute", call(&Board::host_compute, "duration"));
  type.def("share_blocks", [](Handle& self, const py::object& object) {
    const auto board = self.board();
    auto exchange = std::make_shared<PythonExchange>(object);
    without_interpreter([&] { board->share_blocks(std::move(exchange)); });
  });
  type.def("set_brick_detail", call(&Board::set_brick_detail, "detail"));
  type.def("brick_detail", call(&Board::brick_detail));
  type.def("set_time_limit", call(&Board::set_time_limit, "limit"));
  type.def("counters", call(&Board::counters));

  using Listed = std::tuple<std::string, std::string, std::uint64_t>;  // a counter's name, unit, value
  module.def("fidelity_report", [](const std::vector<Listed>& counters) {
    std::vector<Counter> list;
    for (const auto& [name, unit, value] : counters) list.push_back({name, unit, value});
    return write(fidelity_report(Counters(std::move(list))));
  });
  module.def("enumerate", call(&enumerate));
  module.def("clip_to_volume", [](const py::object& rays, const py::object& dims) {
    const auto within = read_as<Dims>(dims, "dims");
    std::vector<HostRay> kept;
    for (const HostRay& ray : items_of<HostRay>(rays, "rays")) {
      if (const auto part = clip_to_volume(ray, within)) kept.push_back(*part);
    }
    return to_array(std::move(kept));
  });
}

}  // namespace gicube::python
