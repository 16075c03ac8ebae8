// The board's error replies as the driver's typed errors.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "gicube/error.h"
#include "gicube/wire/frame.h"

namespace gicube {

// The text of an error payload: printable, and cut at a length that fits a message.
std::string error_text(std::span<const std::uint8_t> payload);

// True if the board closes the session with this error.
bool ends_session(wire::ErrorCode code);

// What a board's last word with this error means for the session.
Loss cause_of(wire::ErrorCode last_word);

// Throws what `code` stands for, `text` being the board's own words. Only for codes other than kNone.
[[noreturn]] void throw_error(wire::ErrorCode code, const std::string& text);

}  // namespace gicube
