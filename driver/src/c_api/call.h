// What every function of the C ABI is made of: the board's handle, checks of arguments, and call(), which catches and remembers.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "encode/argument.h"
#include "gicube/board.h"
#include "gicube/c_api.h"

struct GICUBE_HIDDEN gicube_board {
  explicit gicube_board(gicube::Board opened) : board(std::move(opened)) {}

  gicube::Board board;
  std::mutex mutex;                                   // of what follows; never held while the board works
  std::map<std::uint32_t, gicube::RayBatch> arrived;  // polled, and not received yet
  std::vector<std::uint32_t> announce;  // of those, in their order, the ones to tell gicube_poll()'s caller
  std::vector<std::string> warnings;    // of the last illumination
  std::pair<int, int> framebuffer{};    // width and height
  gicube::Sampling sampling{};          // of the last view rendered
  std::map<std::uint32_t, std::vector<std::size_t>> legs;  // of the lines of a batch, by its ticket
  std::string why_invisible;                               // of the last picture read; empty: something is visible
};

namespace gicube::c_api {

// A callback of the caller's asked for the end of the call.
struct Stopped : Error {
  using Error::Error;
};

// Keeps the error that is being handled for gicube_last_error(), and returns its status. Never throws.
gicube_status remember_current_error() noexcept;

template <std::invocable Work>
gicube_status call(const Work& work) noexcept {
  try {
    work();
    return GICUBE_OK;
  } catch (...) {
    return remember_current_error();
  }
}

// Checks of arguments; each throws BadArgument that names it.

template <typename T>
T& checked(const char* name, T* pointer) {
  if (pointer == nullptr) throw BadArgument(name, "a pointer", "NULL");
  return *pointer;
}

// `count` elements at `pointer`, which may be NULL only if there are none.
template <typename T>
T* checked(const std::string& name, T* pointer, std::size_t count) {
  constexpr std::size_t kMax = PTRDIFF_MAX / sizeof(T);
  expect(count <= kMax, name, fmt::format("at most {} of them", kMax), count);
  if (pointer == nullptr && count > 0) throw BadArgument(name, "a pointer", "NULL");
  return pointer;
}

// The size of an array that the call fills or takes.
inline void check_count(const std::string& name, std::size_t got, std::size_t expected) {
  expect(got == expected, name, fmt::format("{}", expected), got);
}

template <typename Enum>
Enum choice(const std::string& name, std::int32_t value, Enum last) {
  const auto max = static_cast<std::int32_t>(last);
  expect(value >= 0 && value <= max, name, fmt::format("0..{}", max), value);
  return static_cast<Enum>(value);
}

inline bool truth(const std::string& name, std::int32_t value) {
  expect(value == 0 || value == 1, name, "0 or 1", value);
  return value == 1;
}

inline gicube_board& checked_board(gicube_board* board) {
  if (board == nullptr) throw BadArgument("board", "an open board", "NULL");
  return *board;
}

// A call about a board, which is checked before its other arguments: work(its handle).
template <std::invocable<gicube_board&> Work>
gicube_status on_board(gicube_board* board, const Work& work) noexcept {
  return call([&] { work(checked_board(board)); });
}

// The caller's progress callback as the driver's; empty if it is NULL.
inline Progress to_progress(gicube_progress progress, void* user) {
  if (progress == nullptr) return {};
  return [progress, user](std::uint32_t done, std::uint32_t all) {
    if (progress(user, done, all) != 0) throw Stopped("the progress callback ended the call");
  };
}

inline Vec3 to_vec3(const double (&xyz)[3]) { return {xyz[0], xyz[1], xyz[2]}; }

inline void put(Vec3 from, double (&xyz)[3]) {
  xyz[0] = from.x;
  xyz[1] = from.y;
  xyz[2] = from.z;
}

gicube_lighting_report to_c(const LightingReport& report);
View to_view(const gicube_view* given, const std::string& name);

// Records begin with their size, since a caller may have been compiled with an older or a newer version of them. Which of their
// fields is which one of the C++ API is named once, for both ways.

inline constexpr std::size_t kLargestRecord = 65'536;  // bytes, chosen: a size beyond is no size but a stray value

// The size of a record's first version: fields from there on came later, and older callers do not have them. A record
// that is not named here has never grown; tests compare all of them with the headers of past releases.
template <typename Record>
inline constexpr std::size_t kFirstSize = sizeof(Record);
template <>
inline constexpr std::size_t kFirstSize<gicube_open_options> = offsetof(gicube_open_options, go_on);
template <>
inline constexpr std::size_t kFirstSize<gicube_board_info> = offsetof(gicube_board_info, irradiance_words);
template <>
inline constexpr std::size_t kFirstSize<gicube_ray_request> = offsetof(gicube_ray_request, sampled_as);
template <>
inline constexpr std::size_t kFirstSize<gicube_view> = offsetof(gicube_view, lamps);
template <>
inline constexpr std::size_t kFirstSize<gicube_volume> = offsetof(gicube_volume, find_gradients);
template <>
inline constexpr std::size_t kFirstSize<gicube_lighting_report> = offsetof(gicube_lighting_report, escaped_by_face);
template <>
inline constexpr std::size_t kFirstSize<gicube_material> = offsetof(gicube_material, scattering_colour);
template <>
inline constexpr std::size_t kFirstSize<gicube_illumination> = offsetof(gicube_illumination, light_colours);
template <>
inline constexpr std::size_t kFirstSize<gicube_batch_report> = offsetof(gicube_batch_report, escaped_by_face);

// Throws BadArgument.
template <typename Record>
void check_size(const std::string& name, const Record* record, std::size_t size) {
  if (record == nullptr) throw BadArgument(name, "a pointer", "NULL");
  expect(size >= kFirstSize<Record> && size <= kLargestRecord, name + ".size",
         fmt::format("{}..{} (sizeof the record)", kFirstSize<Record>, kLargestRecord), size);
}
// Of a record that may be NULL.
template <typename Record>
void check_optional(const std::string& name, const Record* record) {
  if (record != nullptr) check_size(name, record, record->size);
}

// Overwrites `record`, which holds the defaults, with the fields that the caller's has. Throws BadArgument.
template <typename Record>
void read_record(const std::string& name, const Record* given, Record& record) {
  check_size(name, given, given == nullptr ? 0 : given->size);
  const auto* bytes = reinterpret_cast<const unsigned char*>(given);
  for (std::size_t i = sizeof(Record); i < given->size; ++i) {
    const auto unknown = [] {
      return fmt::format("zeros in fields that this library does not know (from byte {} on)", sizeof(Record));
    };
    if (bytes[i] != 0) throw BadArgument(name, unknown(), fmt::format("{} at byte {}", bytes[i], i));
  }
  std::memcpy(static_cast<void*>(&record), given, std::min<std::size_t>(given->size, sizeof(Record)));
}

// Fills the caller's record of `size` bytes. Throws BadArgument.
template <typename Record>
void write_record(const std::string& name, Record* out, std::size_t size, Record record) {
  check_size(name, out, size);
  record.size = static_cast<std::uint32_t>(size);
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &record, std::min(size, sizeof(Record)));
}
template <typename Record>
void write_record(const std::string& name, Record* out, const Record& record) {
  write_record(name, out, out == nullptr ? 0 : out->size, record);
}

// Copies fields from a record, checked, or to it. `record`: its name in refusals.
template <bool kToRecord>
struct Copy {
  const char* record;

  template <typename C, typename T>
  void number(C& c, T& value) const {
    if constexpr (kToRecord) {
      c = static_cast<C>(value);
    } else {
      value = static_cast<T>(c);
    }
  }
  void truth(const char* field, std::int32_t& c, bool& value) const {
    if (kToRecord) {
      c = value;
    } else {
      value = c_api::truth(name(field), c);
    }
  }
  template <typename Enum>
  void choice(const char* field, std::int32_t& c, Enum& value, Enum last) const {
    if (kToRecord) {
      c = static_cast<std::int32_t>(value);
    } else {
      value = c_api::choice(name(field), c, last);
    }
  }
  void vector(double (&c)[3], Vec3& value) const {
    if (kToRecord) {
      put(value, c);
    } else {
      value = to_vec3(c);
    }
  }
  void milliseconds(std::uint64_t& c, std::chrono::milliseconds& value) const {
    constexpr std::uint64_t kLongest = 1000ull * 60 * 60 * 24 * 365;  // chosen: as good as for ever, and fits the clock
    if (kToRecord) {
      c = static_cast<std::uint64_t>(value.count());
    } else {
      value = std::chrono::milliseconds(std::min(c, kLongest));
    }
  }
  void reserved(const char* field, auto& c) const {
    if (!kToRecord) expect(c == 0, name(field), "0", c);
  }

 private:
  std::string name(const char* field) const { return std::string(record) + "." + field; }
};

void copy_fields(const auto& copy, gicube_open_options& c, OpenOptions& options) {
  copy.milliseconds(c.watchdog_ms, options.watchdog);
  copy.number(c.max_rays, options.max_rays);
  copy.truth("keep_volume", c.keep_volume, options.keep_volume);
  copy.number(c.reopen_attempts, options.reopen_attempts);
  copy.truth("force", c.force, options.force);
  copy.milliseconds(c.wait_for_board_ms, options.wait_for_board);
  copy.reserved("reserved", c.reserved);
  copy.truth("go_on", c.go_on, options.go_on);
  copy.reserved("reserved_too", c.reserved_too);
  copy.number(c.max_waiting_rays, options.max_waiting_rays);
  copy.choice("back_pressure", c.back_pressure, options.back_pressure, BackPressure::kThrow);
}

void copy_fields(const auto& copy, gicube_volume& c, VolumeView& volume) {
  copy.choice("type", c.type, volume.type, SampleType::kFloat32);
  for (std::size_t axis = 0; axis < volume.dims.size(); ++axis) copy.number(c.dims[axis], volume.dims[axis]);
  copy.vector(c.spacing, volume.spacing);
  copy.truth("find_gradients", c.find_gradients, volume.find_gradients);
  copy.reserved("reserved", c.reserved);
}

void copy_fields(const auto& copy, gicube_shading& c, Shading& shading) {
  copy.reserved("reserved", c.reserved);
  copy.number(c.ambient, shading.phong.ambient);
  copy.number(c.diffuse, shading.phong.diffuse);
  copy.number(c.specular, shading.phong.specular);
  copy.number(c.shininess, shading.phong.shininess);
  copy.vector(c.light, shading.light);
}

void copy_fields(const auto& copy, gicube_material& c, Material& material) {
  copy.number(c.scattering, material.scattering);
  copy.choice("bsdf", c.bsdf, material.bsdf, Bsdf::kTrap);
  copy.number(c.gloss, material.gloss);
  copy.truth("seen_through_scattering", c.seen_through_scattering, material.seen_through_scattering);
  copy.number(c.routine, material.routine);
  copy.truth("surface", c.surface, material.surface);
  for (std::size_t i = 0; i < 3; ++i) copy.number(c.scattering_colour[i], material.scattering_colour[i]);
}

void copy_fields(const auto& copy, gicube_illumination& c, Illumination& settings) {
  copy.choice("albedo", c.albedo, settings.albedo, Albedo::kHigh);
  copy.choice("rules", c.rules, settings.rules, EnergyRules::kConserving);
  copy.number(c.rays_per_face_voxel, settings.rays_per_face_voxel);
  copy.number(c.step, settings.step);
  copy.truth("jitter", c.jitter, settings.jitter);
  copy.truth("leap", c.leap, settings.leap);
  copy.number(c.lifetime, settings.lifetime);
  copy.number(c.seed, settings.seed);
}

void copy_fields(const auto& copy, gicube_view& c, View& view) {
  copy.vector(c.eye, view.eye);
  copy.vector(c.look_at, view.look_at);
  copy.vector(c.up, view.up);
  copy.number(c.fov_degrees, view.fov_degrees);
  copy.number(c.orthographic_height, view.orthographic_height);
  copy.number(c.width, view.width);
  copy.number(c.height, view.height);
  copy.number(c.samples_per_axis, view.samples_per_axis);
  copy.choice("filter", c.filter, view.filter, PixelFilter::kTent);
  copy.number(c.step, view.step);
  copy.number(c.opacity_threshold, view.opacity_threshold);
  copy.truth("shade", c.shade, view.shade);
  copy.truth("jitter", c.jitter, view.jitter);
  copy.truth("leap", c.leap, view.leap);
  copy.truth("irradiance", c.irradiance, view.irradiance);
  copy.truth("incident", c.incident, view.incident);
  copy.reserved("reserved", c.reserved);
  copy.number(c.exposure, view.exposure);
  copy.truth("scatter", c.scatter, view.scatter);
  copy.truth("high_albedo", c.high_albedo, view.high_albedo);
  copy.number(c.lifetime, view.lifetime);
  copy.number(c.seed, view.seed);
}

void copy_fields(const auto& copy, gicube_ray_request& c, RayRequest& request) {
  copy.choice("type", c.type, request.type, RayType::kBackproject);
  copy.number(c.opacity, request.opacity);
  copy.choice("albedo", c.albedo, request.albedo, Albedo::kHigh);
  copy.choice("rules", c.rules, request.rules, EnergyRules::kConserving);
  copy.number(c.lifetime, request.lifetime);
  copy.number(c.step, request.step);
  copy.truth("leap", c.leap, request.leap);
  copy.reserved("reserved", c.reserved);
  copy.choice("words", c.words, request.words, SumWords::kSums);
}

void copy_fields(const auto& copy, gicube_pair_request& c, PairRequest& request) {
  copy.number(c.rays, request.rays);
  copy.number(c.first, request.first);
  copy.number(c.seed, request.seed);
  copy.number(c.opacity, request.opacity);
  copy.choice("made", c.made, request.made, PairRays::kByHost);
  copy.number(c.step, request.step);
  copy.truth("leap", c.leap, request.leap);
}

// For ..._init(): what the C++ API has by default.
template <typename T, typename Record>
gicube_status init(const char* name, Record* out, std::size_t size) {
  return call([&] {
    Record record{};
    T value;
    copy_fields(Copy<true>{""}, record, value);
    write_record(name, out, size, record);
  });
}

// What the caller's record says. Throws BadArgument. Leaves in `record` what was read, for fields that are no plain values.
template <typename T, typename Record>
T read_fields(const char* name, const Record* given, Record& record) {
  T value;
  record = {};
  copy_fields(Copy<true>{""}, record, value);
  read_record(name, given, record);
  copy_fields(Copy<false>{name}, record, value);
  return value;
}

template <typename T, typename Record>
T read_fields(const char* name, const Record* given) {
  Record record;
  return read_fields<T>(name, given, record);
}

// The same of a record that may be NULL, for all defaults.
template <typename T, typename Record>
T read_optional(const char* name, const Record* given) {
  return given == nullptr ? T() : read_fields<T>(name, given);
}

}  // namespace gicube::c_api
