#include <dlfcn.h>

#include <cstring>
#include <string>

#include "host.h"

namespace gicube::emu {

namespace {

template <std::size_t kSize>
void write(char (&to)[kSize], const std::string& text) {
  to[text.copy(to, kSize - 1)] = '\0';
}

// Returns the description that the library's exported function returns, or null; the report then states the reason.
template <typename Description>
const Description* described_by(const std::string& function, const std::string& file, Loading& report) {
  void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const text = ::dlerror();
    const std::string reason = text != nullptr ? text : "no reason given";
    // The reason may name another library.
    write(report.fault, reason.starts_with(file) ? reason : file + ": " + reason);
    return nullptr;
  }
  void* const symbol = ::dlsym(library, function.c_str());
  if (symbol == nullptr) {
    write(report.fault, file + ": expected a function " + function + ", got none");
    return nullptr;
  }
  try {
    const auto* const description = reinterpret_cast<const Description* (*)()>(symbol)();
    if (description == nullptr) write(report.fault, file + ": " + function + "() returned null");
    return description;
  } catch (...) {
    write(report.fault, file + ": " + function + "() threw an exception");
    return nullptr;
  }
}

RoutineDescription description_of(const gicube_bsdf& routine) {
  RoutineDescription out;
  out.abi = routine.abi;
  out.size = routine.size;
  if (out.abi != GICUBE_BSDF_ABI || out.size < sizeof routine) return out;
  if (routine.name != nullptr) write(out.name, {routine.name, ::strnlen(routine.name, kMaxName)});
  out.cycles = routine.cycles;
  out.cycle_budget = routine.cycle_budget;
  out.has_scatter = routine.scatter != nullptr ? 1 : 0;
  out.has_check = routine.check != nullptr ? 1 : 0;
  return out;
}

std::string fault(const gicube_observer& observer) {
  if (observer.abi != GICUBE_OBSERVER_ABI) {
    return "abi: expected " + std::to_string(GICUBE_OBSERVER_ABI) + ", got " + std::to_string(observer.abi);
  }
  if (observer.size < sizeof observer) {
    return "size: expected at least " + std::to_string(sizeof observer) + ", got " + std::to_string(observer.size);
  }
  return observer.take == nullptr ? "take: expected a function, got null" : "";
}

}  // namespace

const gicube_bsdf* load_routine(const char* file, Loading& report) {
  const auto* const routine = described_by<gicube_bsdf>("gicube_bsdf_describe", file, report);
  if (routine != nullptr) report.description = description_of(*routine);
  return routine;
}

const gicube_observer* load_observer(const char* file, Loading& report) {
  const auto* const observer = described_by<gicube_observer>("gicube_observer_describe", file, report);
  const std::string what = observer != nullptr ? fault(*observer) : "";
  if (what.empty()) return observer;
  write(report.fault, std::string(file) + ": " + what);
  return nullptr;
}

}  // namespace gicube::emu
