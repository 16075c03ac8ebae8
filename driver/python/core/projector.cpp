// gicube._core.Projector: line integrals for detectors anywhere, and their transpose.
#include "gicube/projector.h"

#include "call.h"

namespace gicube::python {
namespace {

// A board that is closed meanwhile is missed by the next call.
struct Pair {
  py::object handle;
  Board* board;
  Projector projector;

  auto with_board(const auto& work) {
    const auto open = handle.cast<const Handle&>().board();  // open while the call lasts
    if (open.get() != board) throw DeviceLost("the projector's board was closed");
    return without_interpreter(work);
  }
};

std::unique_ptr<Pair> made(const py::object& handle, const py::dict& fields, const py::array& views) {
  const auto board = handle.cast<const Handle&>().board();
  ProjectorSetup setup;
  setup.dims = read_as<Dims>(fields["dims"], "dims");
  setup.spacing = read_as<Vec3>(fields["spacing"], "spacing");
  setup.columns = read_as<int>(fields["columns"], "columns");
  setup.rows = read_as<int>(fields["rows"], "rows");
  setup.step = read_as<double>(fields["step"], "step");
  const auto numbers = items_of<double>(views, "views");
  const auto vector = [&numbers](std::size_t i) { return Vec3{numbers[i], numbers[i + 1], numbers[i + 2]}; };
  for (std::size_t i = 0; i + 12 <= numbers.size(); i += 12) {
    setup.views.push_back({vector(i), vector(i + 3), vector(i + 6), vector(i + 9)});
  }
  return std::unique_ptr<Pair>(new Pair{handle, board.get(), Projector(*board, std::move(setup))});
}

std::vector<std::size_t> indices_of(const py::object& views) {
  return read_as<std::vector<std::size_t>>(views, "views");
}

}  // namespace

void add_projector(py::module_& module) {
  py::class_<Pair> type(module, "Projector");
  type.def(py::init(&made));
  type.def("project", [](Pair& self, const py::array& volume, const py::object& views) {
    const auto values = items_of<float>(volume, "volume");
    const auto some = indices_of(views);
    return to_array(self.with_board([&] { return self.projector.project(values, some); }));
  });
  type.def("backproject", [](Pair& self, const py::array& given, const py::object& views) {
    const auto values = items_of<float>(given, "values");
    const auto some = indices_of(views);
    return to_array(self.with_board([&] { return self.projector.backproject(values, some); }));
  });
  type.def("counts", [](const Pair& self) {
    const ProjectorCounts& counts = self.projector.counts();
    return py::make_tuple(counts.rays, counts.deposits, counts.overflowed);
  });
}

}  // namespace gicube::python
