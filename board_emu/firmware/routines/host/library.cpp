#include "library.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <string>

namespace gicube::emu {

namespace {

template <std::size_t kSize>
void write(char (&to)[kSize], const std::string& text) {
  to[text.copy(to, kSize - 1)] = '\0';
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

void scatter(const gicube_bsdf& routine, CallSlot& slot) {
  const std::uint32_t count = slot.count;
  for (std::uint32_t i = 0; i < count; ++i) {
    gicube_bsdf_event event = slot.events[i].event;
    event.parameters = slot.events[i].parameters;
    gicube_bsdf_answer answer{};
    answer.passes = 1;
    answer.cycles = routine.cycles;
    routine.scatter(&event, &answer);
    slot.answers[i] = answer;
    slot.turn.step();
  }
}

}  // namespace

const gicube_bsdf* load(const char* file, Loading& report) {
  const std::string name = file;
  void* const library = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const text = ::dlerror();
    write(report.fault, text != nullptr ? text : name + ": no reason given");
    return nullptr;
  }
  void* const symbol = ::dlsym(library, "gicube_bsdf_describe");
  if (symbol == nullptr) {
    write(report.fault, name + ": expected a function gicube_bsdf_describe, got none");
    return nullptr;
  }
  try {
    const gicube_bsdf* const routine = reinterpret_cast<const gicube_bsdf* (*)()>(symbol)();
    if (routine != nullptr) {
      report.description = description_of(*routine);
    } else {
      write(report.fault, name + ": gicube_bsdf_describe() returned null");
    }
    return routine;
  } catch (...) {
    write(report.fault, name + ": gicube_bsdf_describe() threw an exception");
    return nullptr;
  }
}

void answer(const gicube_bsdf& routine, CallSlot& slot) {
  slot.outcome = Outcome::kReturned;
  try {
    if (slot.call == CallKind::kScatter) {
      scatter(routine, slot);
    } else {
      slot.text[0] = '\0';
      const CallSlot::Event& first = slot.events[0];
      slot.verdict = routine.check(first.parameters, first.event.parameter_count, slot.text, sizeof slot.text);
    }
  } catch (const std::exception& error) {
    write(slot.text, error.what());
    slot.outcome = Outcome::kThrew;
  } catch (...) {
    slot.text[0] = '\0';
    slot.outcome = Outcome::kThrew;
  }
}

}  // namespace gicube::emu
