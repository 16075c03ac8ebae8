#include "call.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <stdexcept>

#include "gicube/version.h"

namespace gicube::c_api {
namespace {

// The target of gicube_last_error(). `text` is empty or incomplete if there was no memory for the words.
struct LastError {
  std::string words, field;
  std::int32_t loss = GICUBE_LOSS_NONE;
  const char* text = "";
};

LastError& last_error() {
  thread_local LastError error;
  return error;
}

void keep(const char* words, const std::string& field, std::int32_t loss = GICUBE_LOSS_NONE) {
  LastError& last = last_error();
  last.loss = loss;
  last.text = "there was no memory for the error's own words";
  last.field.clear();
  last.words = words;
  last.text = last.words.c_str();
  last.field = field;
}

template <typename Kind>
bool is(const Error& error) {
  return dynamic_cast<const Kind*>(&error) != nullptr;
}

gicube_status status_of(const Error& error) {
  struct Entry {
    bool (*is)(const Error&);
    gicube_status status;
  };
  static constexpr Entry kStatuses[] = {{is<Stopped>, GICUBE_STOPPED},
                                        {is<Cancelled>, GICUBE_STOPPED},
                                        {is<OpenFailed>, GICUBE_OPEN_FAILED},
                                        {is<BoardBusy>, GICUBE_BOARD_BUSY},
                                        {is<VersionMismatch>, GICUBE_VERSION_MISMATCH},
                                        {is<Rejected>, GICUBE_REJECTED},
                                        {is<ScatteringFailed>, GICUBE_SCATTERING_FAILED},
                                        {is<Unsupported>, GICUBE_UNSUPPORTED},
                                        {is<TimedOut>, GICUBE_TIMED_OUT},
                                        {is<DeadlinePassed>, GICUBE_DEADLINE_PASSED},
                                        {is<WouldBlock>, GICUBE_WOULD_BLOCK},
                                        {is<MemoryFault>, GICUBE_MEMORY_FAULT}};
  const auto found = std::ranges::find_if(kStatuses, [&](const Entry& each) { return each.is(error); });
  return found == std::end(kStatuses) ? GICUBE_INTERNAL : found->status;
}

gicube_status remember() {
  try {
    throw;
  } catch (const BadArgument& error) {
    keep(error.what(), error.field());
    return GICUBE_BAD_ARGUMENT;
  } catch (const DeviceLost& error) {
    keep(error.what(), {}, static_cast<std::int32_t>(error.cause()));
    return GICUBE_DEVICE_LOST;
  } catch (const Error& error) {
    keep(error.what(), {});
    return status_of(error);
  } catch (const std::exception& error) {
    const bool no_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                           dynamic_cast<const std::length_error*>(&error) != nullptr;  // a size that no memory holds
    keep(no_memory ? "out of memory" : error.what(), {});
    return no_memory ? GICUBE_NO_MEMORY : GICUBE_INTERNAL;
  } catch (...) {
    keep("something that is no std::exception was thrown", {});
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
  static constexpr const char* kNames[] = {"GICUBE_OK",
                                           "GICUBE_BAD_ARGUMENT",
                                           "GICUBE_OPEN_FAILED",
                                           "GICUBE_BOARD_BUSY",
                                           "GICUBE_VERSION_MISMATCH",
                                           "GICUBE_REJECTED",
                                           "GICUBE_SCATTERING_FAILED",
                                           "GICUBE_UNSUPPORTED",
                                           "GICUBE_DEVICE_LOST",
                                           "GICUBE_TIMED_OUT",
                                           "GICUBE_DEADLINE_PASSED",
                                           "GICUBE_WOULD_BLOCK",
                                           "GICUBE_MEMORY_FAULT",
                                           "GICUBE_STOPPED",
                                           "GICUBE_NO_MEMORY",
                                           "GICUBE_INTERNAL"};
  static_assert(std::size(kNames) == GICUBE_INTERNAL + 1);
  return status >= 0 && status <= GICUBE_INTERNAL ? kNames[status] : "?";
}
}
