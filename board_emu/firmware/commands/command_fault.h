// What is wrong with a command, as the text of its error completion.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "command_result.h"
#include "gicube/wire/command.h"
#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

inline constexpr const char* kNoVolume = "no volume: VOLUME_X, VOLUME_Y and VOLUME_Z are not all set";

CommandResult refuse(const std::string& text);

// "field: expected range, got value"
std::string expected(const std::string& field, const std::string& range, std::uint64_t got);

// Of a rendering command, if anything.
std::optional<std::string> fault(const wire::RenderCommand& command, std::uint64_t framebuffer_mb);

// Of a ray that the host sent, if anything.
std::optional<std::string> fault(const wire::Ray& ray, const Point& extent);

}  // namespace gicube::emu
