// The driver's errors as the classes of gicube.errors, with their fields.
#include "gicube/scene/error.h"
#include "parts.h"
#include "records.h"

namespace gicube::python {
namespace {

// The class that has the same name. A test finds those that there are.
py::object class_of(const Error& error) {
  std::string name = typeid(error).name();
  py::detail::clean_type_id(name);
  return py::module_::import("gicube.errors").attr(name.substr(name.rfind(':') + 1).c_str());
}

// Arguments of the Python exception's constructor.
py::tuple carried(const Error& error) {
  if (const auto* wrong = dynamic_cast<const BadArgument*>(&error)) {
    return py::make_tuple(wrong->field(), wrong->expected(), wrong->got());
  }
  const py::str text = decoded(error.what());
  if (const auto* lost = dynamic_cast<const DeviceLost*>(&error)) return py::make_tuple(text, write(lost->cause()));
  const auto* input = dynamic_cast<const scene::InputError*>(&error);
  if (input == nullptr) return py::make_tuple(text);
  const py::object fault_class = py::module_::import("gicube.errors").attr("Fault");
  py::list faults;
  for (const scene::Fault& fault : input->faults()) {
    faults.append(fault_class(decoded(fault.file), fault.line, decoded(fault.field), decoded(fault.expected),
                              decoded(fault.got), decoded(fault.text)));
  }
  return py::make_tuple(text, faults);
}

}  // namespace

void add_errors() {
  // By value: pybind11's type of a translator.
  // NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_local_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const Error& error) {
      const py::object type = class_of(error);
      PyErr_SetObject(type.ptr(), type(*carried(error)).ptr());
    }
  });
}

}  // namespace gicube::python
