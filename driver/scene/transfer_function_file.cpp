#include "gicube/scene/transfer_function_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <ranges>

#include "scene/common/checks.h"
#include "scene/common/whole_file.h"

namespace gicube::scene {
namespace {

using Words = std::vector<std::string_view>;  // of a line, without its comment

// Reads one statement per call, and collects all faults.
struct Parser {
  const std::string& name;
  std::vector<Fault> faults{};
  int line_number = 0;
  bool scaled = false;
  TransferFunctionFile file{};

  void statement(int line, const Words& words) {
    line_number = line;
    if (words.empty()) return;
    if (words[0] == "values") return scale(words);
    if (words[0] == "colour" || words[0] == "color") return point(words, true);
    if (words[0] == "opacity") return point(words, false);
    fault("statement", "values, colour or opacity", in_quotes(words[0]));
  }

  TransferFunctionFile finish() {
    line_number = 0;
    const auto& [colours, opacities] = file.function;
    const bool is_seen = std::ranges::any_of(opacities, [](const OpacityPoint& point) { return point.opacity != 0; });
    if (faults.empty() && opacities.empty()) fault("opacity", "at least one point", "none");
    if (faults.empty() && colours.empty() && is_seen) fault("colour", "at least one point", "none");
    if (!faults.empty()) throw InputError(faults);
    return std::move(file);
  }

  void fault(const std::string& field, const std::string& expected, const std::string& got) {
    std::string place = name.empty() ? "" : name + ": ";
    if (line_number > 0)
      place = name.empty() ? fmt::format("point {}: ", line_number) : fmt::format("{}:{}: ", name, line_number);
    const std::string text = fmt::format("{}{}: expected {}, got {}", place, field, expected, got);
    faults.push_back({name, name.empty() ? 0 : line_number, field, expected, got, text});
  }

  void scale(const Words& words) {
    if (!file.function.colours.empty() || !file.function.opacities.empty() || scaled) {
      return fault("values", "one such statement, before all points", "another");
    }
    scaled = true;
    constexpr std::array kNames{"absolute", "normalised", "hounsfield", "robust"};  // as TransferScale
    const auto found = words.size() == 2 ? std::ranges::find(kNames, words[1]) : kNames.end();
    if (found == kNames.end()) {
      return fault("values", "absolute, normalised, hounsfield or robust",
                   words.size() < 2 ? "nothing" : in_quotes(words.back()));
    }
    file.scale = static_cast<TransferScale>(found - kNames.begin());
  }

  // The numbers after the statement's name; nothing if there is a fault.
  std::optional<std::vector<double>> numbers(const Words& words, std::size_t count, const char* form) {
    if (words.size() != count + 1) {
      fault(std::string(words[0]), form, std::to_string(words.size() - 1) + " values");
      return std::nullopt;
    }
    std::vector<double> values;
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto value = parse_number<double>(words[i]);
      const bool unit = i > 1;
      if (!value || !std::isfinite(*value) || (unit && (*value < 0 || *value > 1))) {
        fault(std::string(words[0]) + (unit ? "" : " value"), unit ? "a number from 0 to 1" : "a finite number",
              in_quotes(words[i]));
        return std::nullopt;
      }
      values.push_back(*value);
    }
    return values;
  }

  template <typename Point>
  bool rises(const std::vector<Point>& points, double value, std::string_view kind) {
    const std::size_t n = points.size();
    if (n == 0 || value > points[n - 1].value) return true;
    if (value == points[n - 1].value && (n == 1 || points[n - 2].value < value)) return true;
    fault(std::string(kind) + " value", fmt::format("a number above {}", points[n - 1].value),
          fmt::format("{}", value));
    return false;
  }

  void point(const Words& words, bool colour) {
    const auto given = numbers(words, colour ? 4 : 2, colour ? "VALUE RED GREEN BLUE" : "VALUE ALPHA");
    if (!given) return;
    const std::vector<double>& v = *given;
    TransferFunction& function = file.function;
    if (colour && rises(function.colours, v[0], words[0])) function.colours.push_back({v[0], {v[1], v[2], v[3]}});
    if (!colour && rises(function.opacities, v[0], words[0])) function.opacities.push_back({v[0], v[1]});
  }
};

}  // namespace

TransferFunctionFile parse_transfer_function(std::string_view text, const std::string& name) {
  Parser parser{name};
  int number = 0;
  for (const auto part : std::views::split(text, '\n')) {
    const std::string_view line(part.begin(), part.end());
    parser.statement(++number, words_of(line.substr(0, line.find('#'))));
  }
  return parser.finish();
}

TransferFunctionFile read_transfer_function(const std::filesystem::path& path) {
  return parse_transfer_function(read_text(path, "a transfer function file"), path.string());
}

TransferFunction in_values_of(const ValueRange& range, const TransferFunctionFile& file) {
  TransferFunction function = file.function;
  if (file.scale == TransferScale::kAbsolute || file.scale == TransferScale::kHounsfield) return function;
  const auto scaled = [&range](double value) { return range.low + value * (range.high - range.low); };
  for (ColourPoint& point : function.colours) point.value = scaled(point.value);
  for (OpacityPoint& point : function.opacities) point.value = scaled(point.value);
  return function;
}

std::string preset_names() {
  return fmt::format("{}", fmt::join(presets() | std::views::transform(&Preset::name), ", "));
}

TransferFunctionFile find_preset(std::string_view name) {
  const auto found = std::ranges::find(presets(), name, &Preset::name);
  if (found != presets().end()) return parse_transfer_function(found->text, std::string(name));
  throw InputError("preset", "one of " + preset_names(), in_quotes(name));
}

TransferFunctionFile find_transfer_function(const std::string& preset_or_path) {
  if (std::ranges::count(presets(), preset_or_path, &Preset::name) > 0) return find_preset(preset_or_path);
  std::error_code error;
  if (std::filesystem::exists(preset_or_path, error)) return read_transfer_function(preset_or_path);
  throw InputError("transfer function", "a file, or one of the presets " + preset_names(), in_quotes(preset_or_path));
}

}  // namespace gicube::scene
