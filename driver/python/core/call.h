// Makes a function of Python from a function of the driver: it converts the arguments, runs the driver's function
// without the interpreter's lock, and converts the result.
#pragma once

#include <functional>

#include "convert.h"
#include "parts.h"
#include "records.h"

namespace gicube::python {

// Types of array elements; gicube.arrays has the dtypes of records.
template <typename T, typename... Each>
concept IsOneOf = (std::is_same_v<T, Each> || ...);
template <typename T>
concept IsItem =
    IsOneOf<T, float, double, std::uint8_t, std::byte, HostRay, TracedRay, Pixel, Element, ElementPair, PairFactor>;

// Clears padding, so that equal records are equal as bytes.
template <typename T>
void clear_padding([[maybe_unused]] std::span<T> values) {
#if defined(__has_builtin)
#if __has_builtin(__builtin_clear_padding)
  if constexpr (std::is_class_v<T>) {
    for (T& value : values) __builtin_clear_padding(&value);
  }
#endif
#endif
}

// An array that takes the vector's memory.
template <IsItem T>
py::array to_array(std::vector<T>&& values) {
  const auto count = static_cast<py::ssize_t>(values.size());
  auto owner = std::make_unique<std::vector<T>>(std::move(values));
  clear_padding(std::span<T>(*owner));
  const void* const data = owner->data();
  py::capsule base(owner.release(), [](void* pointer) { delete static_cast<std::vector<T>*>(pointer); });
  return {py::dtype::of<T>(), {count}, data, base};
}

// The items of an array that gicube.arrays has made: contiguous, of `T` bytes each.
template <IsItem T>
std::span<const T> items_of(py::handle from, const std::string& field) {
  const std::string expected = "a contiguous array of " + std::to_string(sizeof(T)) + " bytes an item";
  if (!py::isinstance<py::array>(from)) refuse(field, expected, from);
  const auto array = py::reinterpret_borrow<py::array>(from);
  const bool fits =
      static_cast<std::size_t>(array.itemsize()) == sizeof(T) && (array.flags() & py::array::c_style) != 0;
  if (!fits) refuse(field, expected, array.dtype());
  return {static_cast<const T*>(array.data()), static_cast<std::size_t>(array.size())};
}

// Holds an argument of that type during the call.
template <typename T>
using Of = std::type_identity<T>;
template <typename T>
T held(Of<T> /*type*/, py::handle from, const char* field) {
  return read_as<T>(from, field);
}
template <typename T>
std::vector<T> held(Of<std::span<const T>> /*type*/, py::handle from, const char* field) {
  return read_as<std::vector<T>>(from, field);
}
template <IsItem T>
std::span<const T> held(Of<std::span<const T>> /*type*/, py::handle from, const char* field) {
  return items_of<T>(from, field);
}
template <IsOneOf<Plan, LightPlan> T>
T held(Of<T> /*type*/, py::handle from, const char* /*field*/) {
  return from.cast<const T&>();
}
template <typename T>
struct Open {
  std::shared_ptr<T> board;
  T& operator*() const { return *board; }
  operator T&() const { return *board; }  // NOLINT(google-explicit-constructor)
};
template <IsOneOf<Board, BoardGroup> T>
Open<T> held(Of<T> /*type*/, py::handle from, const char* /*field*/) {
  return {from.cast<const Owned<T>&>().board()};
}
inline Ticket held(Of<Ticket> /*type*/, py::handle from, const char* field) {
  return {read_as<std::uint32_t>(from, field)};
}
inline DerivedVolume held(Of<DerivedVolume> /*type*/, py::handle from, const char* /*field*/) {
  return derived_of(from);
}
inline VolumeView held(Of<VolumeView> /*type*/, py::handle from, const char* /*field*/) { return view_of(from); }
inline VolumeStream held(Of<VolumeStream> /*type*/, py::handle from, const char* /*field*/) { return stream_of(from); }
inline Progress held(Of<Progress> /*type*/, py::handle from, const char* /*field*/) { return progress_of(from); }
inline ScatteringRoutine held(Of<ScatteringRoutine> /*type*/, py::handle from, const char* /*field*/) {
  return routine_of(from);
}

template <typename T>
py::object given_back(const T& value) {
  return write(value);
}
template <IsItem T>
py::object given_back(std::vector<T>&& values) {
  return to_array(std::move(values));
}
inline py::object given_back(Ticket ticket) { return py::int_(ticket.id); }
Image image_of(const py::array& pixels);
py::object given_back(Image&& image);
py::object given_back(RayBatch&& batch);
py::object given_back(std::vector<RayBatch>&& batches);
py::object given_back(const Counters& counters);
py::object given_back(DerivedVolume&& volume);
template <IsOneOf<Plan, LightPlan> T>
py::object given_back(T&& plan) {
  return py::cast(std::forward<T>(plan));
}

template <typename>
using Given = const py::object&;
template <typename>
using Named = const char*;

// `fields`: the arguments' names in messages; "" for a record that is the whole request.
template <typename Result, typename... Arguments>
auto bound(auto function, Named<Arguments>... fields) {
  return [=](Given<Arguments>... given) -> py::object {
    const std::tuple taken{held(Of<std::decay_t<Arguments>>{}, given, fields)...};
    const auto work = [&] {
      return std::apply([&](const auto&... each) -> Result { return std::invoke(function, each...); }, taken);
    };
    if constexpr (std::is_void_v<Result>) {
      without_interpreter(work);
      return py::none();
    } else {
      return given_back(without_interpreter(work));
    }
  };
}

// A method of the class, or of the module: Board's argument has the name "board".
template <typename Result, typename Class, typename... Arguments>
auto call(Result (Class::*member)(Arguments...), Named<Arguments>... fields) {
  return bound<Result, Class, Arguments...>(member, "", fields...);
}
template <typename Result, typename Class, typename... Arguments>
auto call(Result (Class::*member)(Arguments...) const, Named<Arguments>... fields) {
  return bound<Result, Class, Arguments...>(member, "", fields...);
}
template <typename Result, typename... Arguments>
auto call(Result (*function)(Arguments...), Named<Arguments>... fields) {
  return bound<Result, Arguments...>(function, fields...);
}

}  // namespace gicube::python
