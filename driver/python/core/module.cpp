// gicube._core: the driver and gicube-scene for the Python package, which has the documented classes.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "call.h"

// Vectors are arrays of three in arrays.
template <>
struct pybind11::detail::npy_format_descriptor<gicube::Vec3> : npy_format_descriptor<std::array<double, 3>> {
  static std::string format() { return "(3)d"; }
};

namespace gicube::python {
namespace {

// The dtypes of the records that arrays are made of: gicube.arrays documents them.
void add_dtypes(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(HostRay, id, position, direction, length, energy);
  PYBIND11_NUMPY_DTYPE(TracedRay, id, position, direction, colour, opacity, integral);
  PYBIND11_NUMPY_DTYPE(Element, kind, origin, u, v, w);
  PYBIND11_NUMPY_DTYPE(ElementPair, a, b, id);
  PYBIND11_NUMPY_DTYPE(PairFactor, transported, geometric, standard_error, clear);
  using Rgb = std::array<std::uint8_t, 3>;
  py::detail::npy_format_descriptor<Pixel>::register_dtype(
      {{"rgb", offsetof(Pixel, red), sizeof(Rgb), "(3)B", py::dtype::of<Rgb>()},
       PYBIND11_FIELD_DESCRIPTOR(Pixel, alpha)});
  module.attr("RAY") = py::dtype::of<HostRay>();
  module.attr("TRACED_RAY") = py::dtype::of<TracedRay>();
  module.attr("PIXEL") = py::dtype::of<Pixel>();
  module.attr("ELEMENT") = py::dtype::of<Element>();
  module.attr("ELEMENT_PAIR") = py::dtype::of<ElementPair>();
  module.attr("PAIR_FACTOR") = py::dtype::of<PairFactor>();
}

// The defaults of all records. A test compares those of the dataclasses with them.
template <typename... T>
struct Defaults {
  static py::list all() {
    py::list all;
    (all.append(write(T{})), ...);
    return all;
  }
};

// A forked process ends without the destructors of libraries: some wait for threads that only the parent has
// (log4cplus, by OpenImageIO).
void end_forked_ones() {
  const py::cpp_function in_child([] {
    ::on_exit(
        [](int status, void*) {
          std::fflush(nullptr);
          ::_exit(status);
        },
        nullptr);
  });
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") = in_child);
}

}  // namespace
}  // namespace gicube::python

PYBIND11_MODULE(_core, module) {
  using namespace gicube;
  using namespace gicube::python;
  module.attr("__version__") = GICUBE_VERSION;
  add_dtypes(module);
  module.def("defaults", &EveryRecord<Defaults>::all);
  end_forked_ones();
  add_errors();
  add_board(module);
  add_group(module);
  add_plans(module);
  add_projector(module);
  add_scenes(module);
}
