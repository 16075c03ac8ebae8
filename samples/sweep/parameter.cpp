#include "sweep/parameter.h"

#include <algorithm>
#include <ranges>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/names.h"

namespace gicube::samples::sweep {

Setting parse_setting(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size() || text.front() == '-')
    throw InputError("parameter", "NAME=VALUE, the name without dashes", in_quotes(text));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

Parameter parse_parameter(const std::string& text) {
  const Setting setting = parse_setting(text);
  const char separator = setting.value.find(';') == std::string::npos ? ',' : ';';
  Parameter parameter{setting.name, {}};
  for (const auto part : std::views::split(setting.value, separator)) {
    const std::string value(part.begin(), part.end());
    if (value.empty()) throw InputError(setting.name, "values between separators", in_quotes(text));
    if (std::ranges::count(parameter.values, value) > 0)
      throw InputError(setting.name, "each value once", in_quotes(value) + " twice");
    parameter.values.push_back(value);
  }
  return parameter;
}

std::vector<Point> grid(const std::vector<Parameter>& parameters) {
  std::vector<Point> points(1);
  for (const Parameter& parameter : parameters) {
    std::vector<Point> more;
    for (const Point& point : points) {
      for (const std::string& value : parameter.values) {
        more.push_back(point);
        more.back().push_back({parameter.name, value});
      }
    }
    points = std::move(more);
  }
  return points;
}

Point changed(Point point, const std::vector<Setting>& changes) {
  for (const Setting& change : changes) {
    const auto place = std::ranges::find(point, change.name, &Setting::name);
    if (place == point.end()) {
      point.push_back(change);
    } else {
      place->value = change.value;
    }
  }
  return point;
}

std::vector<std::string> arguments(const Point& point) {
  std::vector<std::string> all;
  for (const Setting& setting : point) {
    if (setting.name == "input") {
      all.insert(all.begin(), setting.value);
    } else if (setting.name.find('.') != std::string::npos) {
      all.insert(all.end(), {"--set", setting.name + "=" + setting.value});
    } else if (setting.value == "on") {
      all.push_back("--" + setting.name);
    } else if (setting.value != "off") {
      all.insert(all.end(), {"--" + setting.name, setting.value});
    }
  }
  return all;
}

}  // namespace gicube::samples::sweep
