// From Python's values to the driver's and back. What has the wrong type raises BadArgument with the field's path.
//
// A record of the driver is a dataclass of gicube.records with the same fields (records.h lists them), an enumeration
// an enum with the same values in the same order.
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
#include "interpreter.h"

namespace gicube::python {

namespace py = pybind11;

// Its fields: specialised in records.h.
template <typename T>
struct Record;

template <typename T>
concept IsRecord = requires {
  Record<T>::fields();
};

[[noreturn]] inline void refuse(const std::string& field, const std::string& expected, py::handle got) {
  throw BadArgument(field, expected, py::repr(got).cast<std::string>().substr(0, 200));
}

// Like os.fsdecode(): a file's name need not be UTF-8.
inline py::str decoded(const std::string& text) {
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeFSDefault(text.c_str()));
}

// A type's own name is that of its class in gicube.records.
template <typename T>
std::string class_name() {
  const std::string whole = py::type_id<T>();
  return whole.substr(whole.rfind(':') + 1);
}
template <typename T>
py::object record_class() {
  return py::module_::import("gicube.records").attr(class_name<T>().c_str());
}

inline void read(py::handle from, const std::string& field, bool& to) {
  if (!py::isinstance<py::bool_>(from) && std::string(Py_TYPE(from.ptr())->tp_name) != "numpy.bool_") {
    refuse(field, "True or False", from);
  }
  to = PyObject_IsTrue(from.ptr()) == 1;
}

template <std::floating_point T>
void read(py::handle from, const std::string& field, T& to) {
  to = static_cast<T>(PyFloat_AsDouble(from.ptr()));
  const bool failed = PyErr_Occurred() != nullptr;
  PyErr_Clear();
  if (failed || py::isinstance<py::bool_>(from)) refuse(field, "a number", from);
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
requires std::is_enum_v<T>
void read(py::handle from, const std::string& field, T& to) {
  const py::object value = py::hasattr(from, "value") ? from.attr("value") : py::reinterpret_borrow<py::object>(from);
  std::string all;
  int index = 0;
  for (const py::handle each : record_class<T>()) {
    if (value.equal(each.attr("value"))) {
      to = static_cast<T>(index);
      return;
    }
    all += (index++ == 0 ? "" : ", ") + each.attr("value").cast<std::string>();
  }
  refuse(field, "a " + class_name<T>() + ": " + all, from);
}

inline std::vector<py::object> items(py::handle from, const std::string& field, const std::string& expected) {
  if (py::isinstance<py::str>(from) || !py::isinstance<py::iterable>(from)) refuse(field, expected, from);
  std::vector<py::object> out;
  for (const py::handle item : from) out.push_back(py::reinterpret_borrow<py::object>(item));
  return out;
}

template <typename T>
void read(py::handle from, const std::string& field, T& to);

template <IsRecord... T>
void read(py::handle from, const std::string& field, std::variant<T...>& to) {
  std::string all;
  const auto try_one = [&]<typename One>(std::type_identity<One>) {
    all += (all.empty() ? "" : ", ") + class_name<One>();
    if (!py::isinstance(from, record_class<One>())) return false;
    read(from, field, to.template emplace<One>());
    return true;
  };
  if (!(try_one(std::type_identity<T>{}) || ...)) refuse(field, "one of " + all, from);
}

// Composite types. A record is read from its dataclass, or from a dict of some of its fields.
template <typename T>
void read(py::handle from, const std::string& field, T& to) {
  if constexpr (std::is_same_v<T, Vec3>) {
    const auto parts = items(from, field, "three numbers");
    if (parts.size() != 3) refuse(field, "three numbers", from);
    read(parts[0], field + ".x", to.x);
    read(parts[1], field + ".y", to.y);
    read(parts[2], field + ".z", to.z);
  } else if constexpr (requires(T made) { made.emplace_back(); }) {
    to.clear();
    for (const py::object& item : items(from, field, "a sequence")) {
      const std::string name = field + "[" + std::to_string(to.size()) + "]";
      read(item, name, to.emplace_back());
    }
  } else if constexpr (requires(T made) { made.has_value(); }) {
    to.reset();
    if (!from.is_none()) read(from, field, to.emplace());
  } else if constexpr (IsRecord<T>) {
    const bool is_dict = py::isinstance<py::dict>(from);
    if (!is_dict && !py::isinstance(from, record_class<T>())) refuse(field, "a " + class_name<T>(), from);
    const auto read_one = [&](const char* name, auto member) {
      if (is_dict && !from.contains(name)) return;
      const py::object value = is_dict ? py::object(from[name]) : py::object(from.attr(name));
      read(value, field.empty() ? name : field + "." + name, to.*member);
    };
    std::apply([&](const auto&... one) { (read_one(one.first, one.second), ...); }, Record<T>::fields());
  } else {  // std::array
    const std::string expected = std::to_string(to.size()) + " numbers";
    const auto parts = items(from, field, expected);
    if (parts.size() != to.size()) refuse(field, expected, from);
    for (std::size_t i = 0; i < to.size(); ++i) read(parts[i], field + "[" + std::to_string(i) + "]", to[i]);
  }
}

// A field of a record that was asked for.
template <typename T>
T read_as(py::handle from, const std::string& field) {
  T to{};
  read(from, field, to);
  return to;
}

template <typename T>
py::object write(const T& from) {
  if constexpr (std::is_enum_v<T>) {
    return py::list(record_class<T>())[static_cast<std::size_t>(from)];
  } else if constexpr (IsRecord<T>) {
    py::dict values;
    const auto write_one = [&](const char* name, auto member) { values[name] = write(from.*member); };
    std::apply([&](const auto&... one) { (write_one(one.first, one.second), ...); }, Record<T>::fields());
    return record_class<T>()(**values);
  } else if constexpr (std::is_same_v<T, Vec3>) {
    return py::make_tuple(from.x, from.y, from.z);
  } else if constexpr (requires(T made) { made.emplace_back(); }) {
    py::list out;
    for (const auto& item : from) out.append(write(item));
    return out;
  } else if constexpr (requires(T made) { made.has_value(); }) {
    return from ? write(*from) : py::none();
  } else if constexpr (requires { std::variant_size<T>::value; }) {
    return std::visit([](const auto& value) { return write(value); }, from);
  } else if constexpr (requires { std::tuple_size<T>::value; }) {  // std::array
    return std::apply([](const auto&... item) { return py::make_tuple(write(item)...); }, from);
  } else {
    return py::cast(from);
  }
}

// Each field as a property of the class that holds it.
template <typename T, typename... Fields>
void add_properties(py::class_<T>& to, const std::tuple<Fields...>& fields) {
  const auto add = [&](const auto& field) {
    to.def_property_readonly(field.first, [member = field.second](const T& self) { return write(self.*member); });
  };
  std::apply([&](const auto&... one) { (add(one), ...); }, fields);
}

}  // namespace gicube::python
