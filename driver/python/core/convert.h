// From Python's values to the driver's and back. What has the wrong type raises BadArgument with the field's path.
//
// A record of the driver is a dataclass of gicube.records with the same fields (records.h lists them), an enumeration is an enum whose
// values are the names of name_of() there.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "gicube/error.h"
#include "gicube/vector.h"

namespace gicube::python {

namespace py = pybind11;

// Names of Python's class for it, and of its fields: specialised in records.h.
template <typename T>
struct Record;
// Names of an enumeration's values, in their order.
template <typename T>
struct Names;

template <typename T>
concept IsRecord = requires {
  Record<T>::kClass;
};
template <typename T>
concept IsEnum = requires {
  Names<T>::kClass;
};

[[noreturn]] inline void refuse(const std::string& field, const std::string& expected, py::handle got) {
  throw BadArgument(field, expected, py::repr(got).cast<std::string>().substr(0, 200));
}

inline py::object record_class(const char* name) { return py::module_::import("gicube.records").attr(name); }

inline void read(py::handle from, const std::string& field, bool& to) {
  if (!py::isinstance<py::bool_>(from) && std::string(Py_TYPE(from.ptr())->tp_name) != "numpy.bool_") {
    refuse(field, "True or False", from);
  }
  to = PyObject_IsTrue(from.ptr()) == 1;
}

inline void read(py::handle from, const std::string& field, double& to) {
  to = py::isinstance<py::bool_>(from) ? -1 : PyFloat_AsDouble(from.ptr());
  const bool failed = PyErr_Occurred() != nullptr;
  PyErr_Clear();
  if (failed || py::isinstance<py::bool_>(from)) refuse(field, "a number", from);
}

inline void read(py::handle from, const std::string& field, float& to) {
  double wide = 0;
  read(from, field, wide);
  to = static_cast<float>(wide);
}

template <std::integral T>
void read(py::handle from, const std::string& field, T& to) {
  using Limits = std::numeric_limits<T>;
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(from.ptr()));
  PyErr_Clear();
  if (!index || py::isinstance<py::bool_>(from)) refuse(field, "an integer", from);
  const py::int_ low(Limits::min()), high(Limits::max());
  if (index < low || index > high) {
    refuse(field, std::to_string(Limits::min()) + ".." + std::to_string(Limits::max()), from);
  }
  to = index.cast<T>();
}

inline void read(py::handle from, const std::string& field, std::chrono::milliseconds& to) {
  double seconds = 0;
  read(from, field, seconds);
  if (!(seconds >= 0 && seconds < 1e9)) refuse(field, "seconds, 0 or more", from);
  to = std::chrono::milliseconds(std::llround(seconds * 1000));
}

inline void read(py::handle from, const std::string& field, std::string& to) {
  if (!py::isinstance<py::str>(from)) refuse(field, "a text", from);
  to = from.cast<std::string>();
}

template <typename T>
void read(py::handle from, const std::string& field, std::vector<T>& to);
template <typename T, std::size_t kCount>
void read(py::handle from, const std::string& field, std::array<T, kCount>& to);
template <typename T>
void read(py::handle from, const std::string& field, std::optional<T>& to);
template <typename... T>
void read(py::handle from, const std::string& field, std::variant<T...>& to);
template <IsRecord T>
void read(py::handle from, const std::string& field, T& to);

template <IsEnum T>
void read(py::handle from, const std::string& field, T& to) {
  const py::object value = py::hasattr(from, "value") ? from.attr("value") : py::reinterpret_borrow<py::object>(from);
  std::string all;
  for (std::size_t i = 0; i < std::size(Names<T>::kNames); ++i) {
    if (py::isinstance<py::str>(value) && value.cast<std::string>() == Names<T>::kNames[i]) {
      to = static_cast<T>(i);
      return;
    }
    all += (i == 0 ? "" : ", ") + std::string(Names<T>::kNames[i]);
  }
  refuse(field, std::string("a ") + Names<T>::kClass + ": " + all, from);
}

inline std::vector<py::object> items(py::handle from, const std::string& field, const std::string& expected) {
  if (py::isinstance<py::str>(from) || !py::isinstance<py::iterable>(from)) refuse(field, expected, from);
  std::vector<py::object> out;
  for (const py::handle item : from) out.push_back(py::reinterpret_borrow<py::object>(item));
  return out;
}

inline void read(py::handle from, const std::string& field, Vec3& to) {
  const auto parts = items(from, field, "three numbers");
  if (parts.size() != 3) refuse(field, "three numbers", from);
  read(parts[0], field + ".x", to.x);
  read(parts[1], field + ".y", to.y);
  read(parts[2], field + ".z", to.z);
}

template <typename T>
void read(py::handle from, const std::string& field, std::vector<T>& to) {
  to.clear();
  for (const py::object& item : items(from, field, "a sequence")) {
    const std::string name = field + "[" + std::to_string(to.size()) + "]";
    read(item, name, to.emplace_back());
  }
}

template <typename T, std::size_t kCount>
void read(py::handle from, const std::string& field, std::array<T, kCount>& to) {
  const std::string expected = std::to_string(kCount) + " numbers";
  const auto parts = items(from, field, expected);
  if (parts.size() != kCount) refuse(field, expected, from);
  for (std::size_t i = 0; i < kCount; ++i) read(parts[i], field + "[" + std::to_string(i) + "]", to[i]);
}

template <typename T>
void read(py::handle from, const std::string& field, std::optional<T>& to) {
  to.reset();
  if (!from.is_none()) read(from, field, to.emplace());
}

template <typename... T>
void read(py::handle from, const std::string& field, std::variant<T...>& to) {
  std::string all;
  const auto try_one = [&]<typename One>(std::type_identity<One>) {
    all += (all.empty() ? "" : ", ") + std::string(Record<One>::kClass);
    if (!py::isinstance(from, record_class(Record<One>::kClass))) return false;
    One value{};
    read(from, field, value);
    to = value;
    return true;
  };
  if (!(try_one(std::type_identity<T>{}) || ...)) refuse(field, "one of " + all, from);
}

// From a dataclass, or from a dict of some of its fields.
template <IsRecord T>
void read(py::handle from, const std::string& field, T& to) {
  const bool is_dict = py::isinstance<py::dict>(from);
  if (!is_dict && !py::isinstance(from, record_class(Record<T>::kClass))) {
    refuse(field, std::string("a ") + Record<T>::kClass, from);
  }
  const auto read_one = [&](const char* name, auto member) {
    if (is_dict && !from.contains(name)) return;
    const py::object value = is_dict ? py::object(from[name]) : py::object(from.attr(name));
    read(value, field.empty() ? name : field + "." + name, to.*member);
  };
  std::apply([&](const auto&... one) { (read_one(one.first, one.second), ...); }, Record<T>::fields());
}

// A field of a record that was asked for.
template <typename T>
T read_as(py::handle from, const std::string& field) {
  T to{};
  read(from, field, to);
  return to;
}

template <typename T>
requires std::integral<T> || std::floating_point<T> py::object write(const T& from) { return py::cast(from); }
inline py::object write(const std::string& from) { return py::str(from); }
inline py::object write(const Vec3& from) { return py::make_tuple(from.x, from.y, from.z); }
template <typename T>
py::object write(const std::vector<T>& from);
template <typename T, std::size_t kCount>
py::object write(const std::array<T, kCount>& from);
template <typename T>
py::object write(const std::optional<T>& from);
template <typename... T>
py::object write(const std::variant<T...>& from);
template <IsRecord T>
py::object write(const T& from);

template <IsEnum T>
py::object write(const T& from) {
  return record_class(Names<T>::kClass)(Names<T>::kNames[static_cast<std::size_t>(from)]);
}

template <typename T>
py::object write(const std::vector<T>& from) {
  py::list out;
  for (const auto& item : from) out.append(write(item));
  return out;
}

template <typename T, std::size_t kCount>
py::object write(const std::array<T, kCount>& from) {
  py::tuple out(kCount);
  for (std::size_t i = 0; i < kCount; ++i) out[i] = write(from[i]);
  return out;
}

template <typename T>
py::object write(const std::optional<T>& from) {
  return from ? write(*from) : py::none();
}

template <typename... T>
py::object write(const std::variant<T...>& from) {
  return std::visit([](const auto& value) { return write(value); }, from);
}

template <IsRecord T>
py::object write(const T& from) {
  py::dict values;
  const auto write_one = [&](const char* name, auto member) { values[name] = write(from.*member); };
  std::apply([&](const auto&... one) { (write_one(one.first, one.second), ...); }, Record<T>::fields());
  return record_class(Record<T>::kClass)(**values);
}

// Each field of a record as a property of the class that holds it.
template <IsRecord T, typename Class>
void add_properties(Class& to) {
  const auto add = [&](const char* name, auto member) {
    to.def_property_readonly(name, [member](const T& self) { return write(self.*member); });
  };
  std::apply([&](const auto&... one) { (add(one.first, one.second), ...); }, Record<T>::fields());
}

// Lets other threads of Python run while `call` works.
auto without_interpreter(const auto& call) {
  const py::gil_scoped_release free;
  return call();
}

}  // namespace gicube::python
