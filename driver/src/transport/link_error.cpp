#include "link_error.h"

#include <algorithm>

#include "gicube/error.h"

namespace gicube {
namespace {

constexpr std::size_t kLongestText = 4000;  // chosen: a configuration's faults, all of them, and no flood

}  // namespace

std::string error_text(std::span<const std::uint8_t> payload) {
  std::string text;
  for (const std::uint8_t byte : payload.first(std::min(payload.size(), kLongestText))) {
    const bool control = (byte < 0x20 && byte != '\n') || byte == 0x7F;
    text += control ? '?' : static_cast<char>(byte);
  }
  return text.empty() ? "no reason given" : text;
}

bool ends_session(wire::ErrorCode code) {
  switch (code) {
    case wire::ErrorCode::kProtocol:
    case wire::ErrorCode::kVersion:
    case wire::ErrorCode::kTooLarge:
    case wire::ErrorCode::kBusy:
    case wire::ErrorCode::kCancelled:
    case wire::ErrorCode::kTaken: return true;
    default: return false;
  }
}

Loss cause_of(wire::ErrorCode last_word) {
  switch (last_word) {
    case wire::ErrorCode::kTaken: return Loss::kTakenOver;
    case wire::ErrorCode::kTooLarge:  // we keep to the limits: it was a size that was damaged
    case wire::ErrorCode::kCorrupted: return Loss::kCorrupted;
    default: return Loss::kEnded;
  }
}

void throw_error(wire::ErrorCode code, const std::string& text) {
  switch (code) {
    case wire::ErrorCode::kBusy: throw BoardBusy("the board is busy: " + text);
    case wire::ErrorCode::kVersion: throw VersionMismatch("the board speaks another version: " + text);
    case wire::ErrorCode::kUnsupported: throw Unsupported(text);
    case wire::ErrorCode::kMemory: throw MemoryFault(text);
    case wire::ErrorCode::kProtocol:
    case wire::ErrorCode::kTooLarge: throw DeviceLost("the board ended the session: " + text, Loss::kEnded);
    case wire::ErrorCode::kCancelled: throw DeviceLost("the board shuts down: " + text, Loss::kEnded);
    case wire::ErrorCode::kCorrupted: throw DeviceLost(text, Loss::kCorrupted);
    case wire::ErrorCode::kTaken: throw DeviceLost(text, Loss::kTakenOver);
    default: throw Rejected(text);
  }
}

}  // namespace gicube
