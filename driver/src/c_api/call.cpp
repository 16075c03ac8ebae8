#include "call.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <stdexcept>

#include "gicube/version.h"

namespace gicube::c_api {
namespace {

// Returned by gicube_last_error(). `text` is empty or incomplete if there was no memory for it.
struct LastError {
  std::string words, field;
  std::int32_t loss = GICUBE_LOSS_NONE;
  const char* text = "";
};

LastError& last_error() {
  thread_local LastError error;
  return error;
}

void keep(const char* words, std::string_view field = {}, std::int32_t loss = GICUBE_LOSS_NONE) {
  LastError& last = last_error();
  last.loss = loss;
  last.text = "there was no memory for the text of the error";
  last.field.clear();
  last.words = words;
  last.text = last.words.c_str();
  last.field = field;
}

template <typename... Kinds>
bool is([[maybe_unused]] const Error& error) {
  return ((dynamic_cast<const Kinds*>(&error) != nullptr) || ...);
}

// By status: its name, and whether it stands for an error.
struct Status {
  const char* name;
  bool (*is)(const Error&);
};
constexpr Status kStatuses[] = {{"GICUBE_OK", is<>},
                                {"GICUBE_BAD_ARGUMENT", is<BadArgument>},
                                {"GICUBE_OPEN_FAILED", is<OpenFailed>},
                                {"GICUBE_BOARD_BUSY", is<BoardBusy>},
                                {"GICUBE_VERSION_MISMATCH", is<VersionMismatch>},
                                {"GICUBE_REJECTED", is<Rejected>},
                                {"GICUBE_SCATTERING_FAILED", is<ScatteringFailed>},
                                {"GICUBE_UNSUPPORTED", is<Unsupported>},
                                {"GICUBE_DEVICE_LOST", is<DeviceLost>},
                                {"GICUBE_TIMED_OUT", is<TimedOut>},
                                {"GICUBE_DEADLINE_PASSED", is<DeadlinePassed>},
                                {"GICUBE_WOULD_BLOCK", is<WouldBlock>},
                                {"GICUBE_MEMORY_FAULT", is<MemoryFault>},
                                {"GICUBE_STOPPED", is<Stopped, Cancelled>},
                                {"GICUBE_NO_MEMORY", is<>},
                                {"GICUBE_INTERNAL", is<Error>}};
static_assert(std::size(kStatuses) == GICUBE_INTERNAL + 1);

gicube_status remember() {
  try {
    throw;
  } catch (const Error& error) {
    const auto* wrong = dynamic_cast<const BadArgument*>(&error);
    const auto* lost = dynamic_cast<const DeviceLost*>(&error);
    keep(error.what(), wrong != nullptr ? std::string_view(wrong->field()) : std::string_view(),
         lost != nullptr ? static_cast<std::int32_t>(lost->cause()) : GICUBE_LOSS_NONE);
    const auto* const found = std::ranges::find_if(kStatuses, [&](const Status& each) { return each.is(error); });
    return static_cast<gicube_status>(found - kStatuses);
  } catch (const std::exception& error) {
    const bool no_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                           dynamic_cast<const std::length_error*>(&error) != nullptr;  // a size beyond any memory
    keep(no_memory ? "out of memory" : error.what());
    return no_memory ? GICUBE_NO_MEMORY : GICUBE_INTERNAL;
  } catch (...) {
    keep("something other than a std::exception was thrown");
    return GICUBE_INTERNAL;
  }
}

static_assert(static_cast<int>(Loss::kClosed) == GICUBE_LOSS_CLOSED &&
              static_cast<int>(Loss::kCorrupted) == GICUBE_LOSS_CORRUPTED &&
              static_cast<int>(Loss::kTimedOut) == GICUBE_LOSS_TIMED_OUT &&
              static_cast<int>(Loss::kTakenOver) == GICUBE_LOSS_TAKEN_OVER &&
              static_cast<int>(Loss::kEnded) == GICUBE_LOSS_ENDED);

}  // namespace

gicube_status remember_current_error() noexcept {
  try {
    return remember();
  } catch (...) {
    return GICUBE_NO_MEMORY;
  }
}

}  // namespace gicube::c_api

extern "C" {

const char* gicube_last_error(void) { return gicube::c_api::last_error().text; }

const char* gicube_last_error_field(void) { return gicube::c_api::last_error().field.c_str(); }

int32_t gicube_last_loss(void) { return gicube::c_api::last_error().loss; }

uint32_t gicube_version(void) { return GICUBE_VERSION_NUMBER; }

const char* gicube_status_name(gicube_status status) {
  using gicube::c_api::kStatuses;
  return status >= 0 && status <= GICUBE_INTERNAL ? kStatuses[status].name : "?";
}
}
