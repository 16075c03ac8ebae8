// gicube._core: the driver and gicube-scene for the Python package, which has the documented classes.
#include "parts.h"
#include "records.h"

namespace gicube::python {
namespace {

template <typename T>
py::dict layout(std::initializer_list<std::pair<const char*, std::size_t>> offsets) {
  py::dict out;
  for (const auto& [name, offset] : offsets) out[name] = offset;
  out["itemsize"] = sizeof(T);
  return out;
}

// Where the fields of the records lie that arrays are made of: gicube.arrays makes dtypes of it.
void add_layouts(py::module_& module) {
  module.attr("HOST_RAY") = layout<HostRay>({{"id", offsetof(HostRay, id)},
                                             {"position", offsetof(HostRay, position)},
                                             {"direction", offsetof(HostRay, direction)},
                                             {"length", offsetof(HostRay, length)},
                                             {"energy", offsetof(HostRay, energy)}});
  module.attr("TRACED_RAY") = layout<TracedRay>({{"id", offsetof(TracedRay, id)},
                                                 {"position", offsetof(TracedRay, position)},
                                                 {"direction", offsetof(TracedRay, direction)},
                                                 {"colour", offsetof(TracedRay, colour)},
                                                 {"opacity", offsetof(TracedRay, opacity)},
                                                 {"integral", offsetof(TracedRay, integral)}});
  module.attr("PIXEL") = layout<Pixel>({{"rgb", offsetof(Pixel, red)}, {"alpha", offsetof(Pixel, alpha)}});
  module.attr("ELEMENT") = layout<Element>({{"kind", offsetof(Element, kind)},
                                            {"origin", offsetof(Element, origin)},
                                            {"u", offsetof(Element, u)},
                                            {"v", offsetof(Element, v)},
                                            {"w", offsetof(Element, w)}});
  module.attr("ELEMENT_PAIR") = layout<ElementPair>(
      {{"a", offsetof(ElementPair, a)}, {"b", offsetof(ElementPair, b)}, {"id", offsetof(ElementPair, id)}});
  module.attr("PAIR_FACTOR") = layout<PairFactor>({{"transported", offsetof(PairFactor, transported)},
                                                   {"geometric", offsetof(PairFactor, geometric)},
                                                   {"standard_error", offsetof(PairFactor, standard_error)},
                                                   {"clear", offsetof(PairFactor, clear)}});
}

// What a record holds if nothing is said: its dataclass must hold the same, which a test compares.
template <typename... T>
void add_defaults(py::module_& module) {
  module.def("defaults", [] {
    py::list all;
    (all.append(write(T{})), ...);
    return all;
  });
}

}  // namespace
}  // namespace gicube::python

PYBIND11_MODULE(_core, module) {
  using namespace gicube;
  using namespace gicube::python;
  module.attr("__version__") = GICUBE_VERSION;
  add_layouts(module);
  add_defaults<ValueRange, Phong, Shading, Material, View, CutPlane, PointLight, DirectionalLight, RectangleLight,
               SphereLight, Illumination, RayRequest, PairRequest, Placement, ScatterAnswer, TransferFunction>(module);
  add_errors();
  add_board(module);
  add_plans(module);
  add_scenes(module);
}
