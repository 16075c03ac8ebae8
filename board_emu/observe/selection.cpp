#include "observe/selection.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <stdexcept>
#include <utility>

namespace gicube::emu {

namespace {

std::optional<std::uint64_t> number(std::string_view text) {
  std::uint64_t out = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(out) : std::nullopt;
}

std::optional<std::array<std::uint64_t, 2>> two_numbers(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto first = number(text.substr(0, colon)), second = number(text.substr(colon + 1));
  return first && second ? std::optional(std::array{*first, *second}) : std::nullopt;
}

[[noreturn]] void refuse(std::string_view name, std::string_view expected, std::string_view got) {
  throw std::invalid_argument(fmt::format("{}: expected {}, got \"{}\"", name, expected, got));
}

CycleWindow window_of(std::string_view name, std::string_view text) {
  if (const auto window = parse_window(text)) return *window;
  refuse(name, "BEGIN:END with BEGIN < END", text);
}

std::uint32_t steps_of(std::string_view part) {
  using enum RayStep;
  const auto bits = [](std::initializer_list<RayStep> steps) {
    std::uint32_t out = 0;
    for (const RayStep step : steps) out |= 1u << static_cast<unsigned>(step);
    return out;
  };
  if (part == "dsp") return bits({kMade, kSent, kKept, kScattered, kWaits, kTaken});
  if (part == "sorter") return bits({kQueued, kOverflowed, kIssued});
  if (part == "pipeline") return bits({kSampled, kLeapt, kFilled, kDeposited, kGone});
  if (part == "links") return bits({kLinked, kArrived});
  refuse("parts", "some of dsp, sorter, pipeline, links with + between", part);
}

// Removes and returns the text up to `mark`, and removes the mark.
std::string_view take_up_to(char mark, std::string_view& text) {
  const std::string_view item = text.substr(0, text.find(mark));
  text.remove_prefix(item.size() < text.size() ? item.size() + 1 : item.size());
  return item;
}

}  // namespace

std::optional<CycleWindow> parse_window(std::string_view text) {
  const auto numbers = two_numbers(text);
  if (!numbers || (*numbers)[1] <= (*numbers)[0]) return std::nullopt;
  return CycleWindow{(*numbers)[0], (*numbers)[1]};
}

Selection parse_selection(std::string_view text) {
  Selection out;
  while (!text.empty()) {
    std::string_view value = take_up_to(',', text);
    const std::string_view name = take_up_to('=', value);
    if (name == "pixel" || name == "life") {
      constexpr std::uint64_t kMost = std::numeric_limits<std::uint16_t>::max() >> 4;
      const auto pixel = two_numbers(value);
      if (!pixel || (*pixel)[0] > kMost || (*pixel)[1] > kMost)
        refuse(name, fmt::format("X:Y of 0 to {}", kMost), value);
      out.pixel = {static_cast<std::uint16_t>((*pixel)[0]), static_cast<std::uint16_t>((*pixel)[1])};
      if (name == "life") out.life = out.pixel;
    } else if (name == "rays") {
      const CycleWindow rays = window_of(name, value);
      out.rays = {rays.begin, rays.end};
    } else if (name == "cycles") {
      out.cycles = window_of(name, value);
    } else if (name == "parts") {
      out.steps = 0;
      do {
        out.steps |= steps_of(take_up_to('+', value));
      } while (!value.empty());
    } else if (name == "counters") {
      out.counters_every = number(value).value_or(0);
      if (out.counters_every == 0) refuse(name, "a number of cycles from 1 on", value);
    } else {
      refuse("item", "one of pixel, life, rays, cycles, parts, counters with = and its value", name);
    }
  }
  if (!out.pixel && !out.rays && out.counters_every == 0)
    refuse("items", "pixel, life, rays or counters among them", "none");
  return out;
}

}  // namespace gicube::emu
