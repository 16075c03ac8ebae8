#include "firmware/routines/plug_in.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <filesystem>
#include <utility>

#include "firmware/routines/time_limit.h"

namespace gicube::emu {

namespace {

constexpr std::size_t kLongestName = 64;
constexpr std::size_t kLongestText = 256;  // of a parameter check

std::string last_dl_error() {
  const char* const text = ::dlerror();
  return text != nullptr ? text : "no reason given";
}

std::string printable(const char* text, std::size_t max_length) {
  std::string out(text, ::strnlen(text, max_length));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < 0x20 || c > 0x7E; }, '?');
  return out;
}

const gicube_bsdf& described(void* object, const std::string& file) {
  void* const symbol = ::dlsym(object, "gicube_bsdf_describe");
  if (symbol == nullptr) throw PlugInFault(file + ": expected a function gicube_bsdf_describe, got none");
  const auto describe = reinterpret_cast<const gicube_bsdf* (*)()>(symbol);
  const gicube_bsdf* description = nullptr;
  if (!run_limited([&] { description = describe(); })) {
    throw PlugInFault(file + ": gicube_bsdf_describe() does not return");
  }
  if (description == nullptr) throw PlugInFault(file + ": gicube_bsdf_describe() returned null");
  return *description;
}

}  // namespace

std::unique_ptr<PlugIn> PlugIn::load(const std::string& file) {
  // A name without a slash would be looked for in the system's library folders.
  void* const object = ::dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (object == nullptr) throw PlugInFault(last_dl_error());
  try {
    return std::make_unique<PlugIn>(described(object, file), file);
  } catch (const PlugInFault&) {
    ::dlclose(object);
    throw;
  } catch (const std::exception& error) {
    throw PlugInFault(file + ": " + error.what());
  }
}

PlugIn::PlugIn(const gicube_bsdf& description, std::string file) : file_(std::move(file)) {
  const auto refuse = [this](const std::string& what) { throw PlugInFault(file_ + ": " + what); };
  const auto expected = [&](const std::string& field, const std::string& range, std::uint64_t got) {
    refuse(field + ": expected " + range + ", got " + std::to_string(got));
  };
  if (description.abi != GICUBE_BSDF_ABI) expected("abi", std::to_string(GICUBE_BSDF_ABI), description.abi);
  if (description.size < sizeof description) {
    expected("size", "at least " + std::to_string(sizeof description), description.size);
  }
  description_ = description;
  if (description.name == nullptr || *description.name == '\0') refuse("name: expected a text, got none");
  name_ = printable(description.name, kLongestName);
  if (description.scatter == nullptr) refuse("scatter: expected a function, got null");
  if (description.cycle_budget < 1) expected("cycle_budget", "at least 1", description.cycle_budget);
  if (description.cycles < 1 || description.cycles > description.cycle_budget) {
    expected("cycles", "1.." + std::to_string(description.cycle_budget), description.cycles);
  }
}

std::string PlugIn::stuck() const {
  stuck_ = true;
  return "did not return within " + std::to_string(kCpuLimit.count()) +
         " ms of processor time; it is not called again before the board process is started anew";
}

std::optional<std::string> PlugIn::fault(std::span<const float> parameters) const {
  if (stuck_) return stuck();
  if (description_.check == nullptr) return std::nullopt;
  std::array<char, kLongestText> text{};
  int verdict = 0;
  try {
    if (!run_limited([&] {
          verdict = description_.check(parameters.data(), static_cast<std::uint32_t>(parameters.size()), text.data(),
                                       text.size());
        })) {
      return stuck();
    }
  } catch (...) {
    return "its parameter check threw an exception";
  }
  if (verdict == 0) return std::nullopt;
  return text[0] != '\0' ? printable(text.data(), text.size()) : "it refuses its parameters and does not say why";
}

ScatterAnswer PlugIn::scatter(const ScatterEvent& event) const {
  if (stuck_) throw RoutineFault(stuck());
  gicube_bsdf_event in{};
  in.size = sizeof in;
  in.tag = event.tag;
  std::copy(event.position.begin(), event.position.end(), in.position);
  std::copy(event.direction.begin(), event.direction.end(), in.direction);
  std::copy(event.normal.begin(), event.normal.end(), in.normal);
  in.opacity = event.opacity;
  in.density = event.density;
  std::copy(event.random.begin(), event.random.end(), in.random);
  in.lighting = event.lighting ? 1 : 0;
  in.generation = event.generation;
  in.parameters = event.parameters.data();
  in.parameter_count = static_cast<std::uint32_t>(event.parameters.size());
  gicube_bsdf_answer out{};
  out.passes = 1;
  out.cycles = description_.cycles;
  bool returned = false;
  try {
    returned = run_limited([&] { description_.scatter(&in, &out); });
  } catch (const std::exception& error) {
    throw RoutineFault(std::string("threw an exception: ") + error.what());
  } catch (...) {
    throw RoutineFault("threw an exception");
  }
  if (!returned) throw RoutineFault(stuck());
  if (out.cycles < 1 || out.cycles > description_.cycle_budget) {
    throw RoutineFault("cycles: expected 1.." + std::to_string(description_.cycle_budget) + ", got " +
                       std::to_string(out.cycles));
  }
  return {{out.direction[0], out.direction[1], out.direction[2]}, out.passes, out.cycles};
}

}  // namespace gicube::emu
