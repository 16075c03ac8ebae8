// A function of Python for each function of the driver: its arguments are read, it works without the interpreter's lock, and what it
// gives back is written.
#pragma once

#include <functional>

#include "convert.h"
#include "parts.h"
#include "records.h"

namespace gicube::python {

// What arrays are made of. gicube.arrays has the dtypes of records under these names.
template <typename T>
constexpr const char* kDtype = nullptr;
template <>
inline constexpr const char* kDtype<float> = "float32";
template <>
inline constexpr const char* kDtype<double> = "float64";
template <>
inline constexpr const char* kDtype<std::uint8_t> = "uint8";
template <>
inline constexpr const char* kDtype<std::byte> = "uint8";
template <>
inline constexpr const char* kDtype<HostRay> = "RAY";
template <>
inline constexpr const char* kDtype<TracedRay> = "TRACED_RAY";
template <>
inline constexpr const char* kDtype<Pixel> = "PIXEL";
template <>
inline constexpr const char* kDtype<Element> = "ELEMENT";
template <>
inline constexpr const char* kDtype<ElementPair> = "ELEMENT_PAIR";
template <>
inline constexpr const char* kDtype<PairFactor> = "PAIR_FACTOR";
template <typename T>
concept IsItem = kDtype<T>
!= nullptr;

// An array that takes the vector's memory.
template <typename T>
py::array to_array(std::vector<T>&& values) {
  const auto count = static_cast<py::ssize_t>(values.size());
  auto owner = std::make_unique<std::vector<T>>(std::move(values));
  const void* const data = owner->data();
  py::capsule base(owner.release(), [](void* pointer) { delete static_cast<std::vector<T>*>(pointer); });
  if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::byte>) {
    return {py::dtype(kDtype<T>), {count}, data, base};
  } else {
    return {py::module_::import("gicube.arrays").attr(kDtype<T>).template cast<py::dtype>(), {count}, data, base};
  }
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

// What holds an argument while the call lasts.
template <typename T>
struct Argument {
  static T read(py::handle from, const char* field) { return read_as<T>(from, field); }
};
template <typename T>
struct Argument<std::span<const T>> {
  static std::vector<T> read(py::handle from, const char* field) { return read_as<std::vector<T>>(from, field); }
};
template <IsItem T>
struct Argument<std::span<const T>> {
  static std::span<const T> read(py::handle from, const char* field) { return items_of<T>(from, field); }
};
template <>
struct Argument<Ticket> {
  static Ticket read(py::handle from, const char* field) { return {read_as<std::uint32_t>(from, field)}; }
};
template <>
struct Argument<VolumeView> {
  static VolumeView read(py::handle from, const char* /*field*/) { return view_of(from); }
};
template <>
struct Argument<Progress> {
  static Progress read(py::handle from, const char* /*field*/) { return progress_of(from); }
};
template <>
struct Argument<ScatteringRoutine> {
  static ScatteringRoutine read(py::handle from, const char* /*field*/) { return routine_of(from); }
};

template <typename T>
py::object given_back(const T& value) {
  return write(value);
}
template <IsItem T>
py::object given_back(std::vector<T>&& values) {
  return to_array(std::move(values));
}
inline py::object given_back(Ticket ticket) { return py::int_(ticket.id); }
py::object given_back(Image&& image);
py::object given_back(std::vector<RayBatch>&& batches);
py::object given_back(const Counters& counters);

template <typename>
using Given = const py::object&;
template <typename>
using Named = const char*;

// `fields` name the arguments in messages; those of a record that stands for all that is asked have "".
template <typename Result, typename... Arguments>
auto bound(auto member, Named<Arguments>... fields) {
  return [=](Handle& self, Given<Arguments>... given) -> py::object {
    const std::tuple taken{Argument<std::decay_t<Arguments>>::read(given, fields)...};
    const auto board = self.board();
    const auto work = [&] {
      return std::apply([&](const auto&... each) { return std::invoke(member, *board, each...); }, taken);
    };
    if constexpr (std::is_void_v<Result>) {
      without_interpreter(work);
      return py::none();
    } else {
      return given_back(without_interpreter(work));
    }
  };
}

template <typename Result, typename... Arguments>
auto call(Result (Board::*member)(Arguments...), Named<Arguments>... fields) {
  return bound<Result, Arguments...>(member, fields...);
}
template <typename Result>
auto call(Result (Board::*member)() const) {
  return bound<Result>(member);
}

}  // namespace gicube::python
