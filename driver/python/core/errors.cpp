// The driver's errors as the classes of gicube.errors, with what they carry.
#include "gicube/scene/error.h"
#include "parts.h"
#include "records.h"

namespace gicube::python {
namespace {

struct ErrorClass {
  const char* name;
  bool (*is)(const Error*);
};

template <typename T>
bool is(const Error* error) {
  return dynamic_cast<const T*>(error) != nullptr;
}

#define GICUBE_ERROR(TYPE) \
  { #TYPE, is < TYPE> }
using scene::FileError;
using scene::InputError;
// A class before its parent.
constexpr ErrorClass kErrorClasses[] = {
    GICUBE_ERROR(BadArgument),      GICUBE_ERROR(DeviceLost),      GICUBE_ERROR(OpenFailed),
    GICUBE_ERROR(BoardBusy),        GICUBE_ERROR(VersionMismatch), GICUBE_ERROR(Rejected),
    GICUBE_ERROR(ScatteringFailed), GICUBE_ERROR(MemoryFault),     GICUBE_ERROR(Unsupported),
    GICUBE_ERROR(DeadlinePassed),   GICUBE_ERROR(WouldBlock),      GICUBE_ERROR(TimedOut),
    GICUBE_ERROR(FileError),        GICUBE_ERROR(InputError),      GICUBE_ERROR(Error),
};
#undef GICUBE_ERROR

py::object error_class(const char* name) { return py::module_::import("gicube.errors").attr(name); }

// What its class is made of.
py::tuple carried(const Error& error) {
  if (const auto* wrong = dynamic_cast<const BadArgument*>(&error)) {
    return py::make_tuple(wrong->field(), wrong->expected(), wrong->got());
  }
  const py::str text(error.what());
  if (const auto* lost = dynamic_cast<const DeviceLost*>(&error)) return py::make_tuple(text, write(lost->cause()));
  const auto* input = dynamic_cast<const InputError*>(&error);
  if (input == nullptr) return py::make_tuple(text);
  const py::object fault_class = error_class("Fault");
  py::list faults;
  for (const scene::Fault& fault : input->faults()) {
    faults.append(fault_class(fault.file, fault.line, fault.field, fault.expected, fault.got, fault.text));
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
      const auto* const found =
          std::ranges::find_if(kErrorClasses, [&](const ErrorClass& each) { return each.is(&error); });
      const py::object type = error_class(found->name);
      PyErr_SetObject(type.ptr(), type(*carried(error)).ptr());
    }
  });
}

}  // namespace gicube::python
