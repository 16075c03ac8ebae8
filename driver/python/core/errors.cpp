// The driver's errors as the classes of gicube.errors, with what they carry.
#include "gicube/scene/error.h"
#include "parts.h"
#include "records.h"

namespace gicube::python {
namespace {

py::object error_class(const char* name) { return py::module_::import("gicube.errors").attr(name); }

void raise(const py::object& type, const py::object& error) { PyErr_SetObject(type.ptr(), error.ptr()); }

void raise_text(const char* name, const std::exception& error) {
  const py::object type = error_class(name);
  raise(type, type(py::str(error.what())));
}

void raise_input(const char* name, const scene::InputError& error) {
  const py::object fault_class = error_class("Fault"), type = error_class(name);
  py::list faults;
  for (const scene::Fault& fault : error.faults()) {
    faults.append(fault_class(fault.file, fault.line, fault.field, fault.expected, fault.got, fault.text));
  }
  raise(type, type(py::str(error.what()), faults));
}

}  // namespace

void add_errors() {
  // By value: pybind11's type of a translator.
  // NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_local_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const BadArgument& error) {
      const py::object type = error_class("BadArgument");
      raise(type, type(error.field(), error.expected(), error.got()));
    } catch (const scene::FileError& error) {
      raise_input("FileError", error);
    } catch (const scene::InputError& error) {
      raise_input("InputError", error);
    } catch (const DeviceLost& error) {
      const py::object type = error_class("DeviceLost");
      raise(type, type(py::str(error.what()), write(error.cause())));
    } catch (const OpenFailed& error) {
      raise_text("OpenFailed", error);
    } catch (const BoardBusy& error) {
      raise_text("BoardBusy", error);
    } catch (const VersionMismatch& error) {
      raise_text("VersionMismatch", error);
    } catch (const Rejected& error) {
      raise_text("Rejected", error);
    } catch (const ScatteringFailed& error) {
      raise_text("ScatteringFailed", error);
    } catch (const MemoryFault& error) {
      raise_text("MemoryFault", error);
    } catch (const Unsupported& error) {
      raise_text("Unsupported", error);
    } catch (const DeadlinePassed& error) {
      raise_text("DeadlinePassed", error);
    } catch (const WouldBlock& error) {
      raise_text("WouldBlock", error);
    } catch (const TimedOut& error) {
      raise_text("TimedOut", error);
    } catch (const Error& error) {
      raise_text("Error", error);
    }
  });
}

}  // namespace gicube::python
