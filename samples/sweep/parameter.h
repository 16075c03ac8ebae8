// What a sweep varies: options of gicube-render and fields of the board's configuration.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gicube::samples::sweep {

// One option of gicube-render without its dashes ("step"; "input" is the scene itself), or a field of the board's
// configuration ("asic.processors"). A flag's value is "on" or "off".
struct Setting {
  std::string name;
  std::string value;

  friend bool operator==(const Setting&, const Setting&) = default;
};

struct Parameter {
  std::string name;
  std::vector<std::string> values;
};

// One run's settings, in the order of the parameters.
using Point = std::vector<Setting>;

// "NAME=V,V..."; values that have commas of their own stand between semicolons: "eye=0,-300,0;0,-400,0".
// Throws InputError.
Parameter parse_parameter(const std::string& text);
// "NAME=VALUE", the value as it stands. Throws InputError.
Setting parse_setting(const std::string& text);

// All combinations; the last parameter varies fastest. One point without settings if there are no parameters.
std::vector<Point> grid(const std::vector<Parameter>& parameters);

// `point` with `changes` in place of its settings of those names, and behind them if it has none.
Point changed(Point point, const std::vector<Setting>& changes);

// As gicube-render takes them: the input first.
std::vector<std::string> arguments(const Point& point);

}  // namespace gicube::samples::sweep
