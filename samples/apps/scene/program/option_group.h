// Command line options in one group of the help text.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/names.h"
#include "scene/program/board_options.h"

namespace gicube::samples {

// Adds options to a group.
class OptionGroup {
 public:
  OptionGroup(CLI::App& app, std::string name) : app_(app), name_(std::move(name)) {}

  template <typename Value>
  CLI::Option* value(const std::string& option, Value& target, const std::string& help) {
    return app_.add_option(option, target, help)->group(name_);
  }
  CLI::Option* flag(const std::string& option, bool& target, const std::string& help) {
    return app_.add_flag(option, target, help)->group(name_);
  }
  // Stays unset without the flag, unlike with add_flag(), which counts from 0.
  CLI::Option* flag(const std::string& option, std::optional<bool>& target, const std::string& help) {
    return app_
        .add_flag_function(
            option, [&target](std::int64_t count) { target = count > 0; }, help)
        ->group(name_);
  }
  // A number whose default the help shows.
  template <typename Value>
  CLI::Option* number(const std::string& option, Value& target, const CLI::Validator& range, const std::string& help) {
    return app_.add_option(option, target, help)->check(range)->capture_default_str()->group(name_);
  }
  CLI::Option* file(const std::string& option, std::filesystem::path& target, const std::string& help) {
    return app_.add_option(option, target, help)->type_name("FILE")->group(name_);
  }
  // One of several names.
  template <typename Value>
  CLI::Option* choice(const std::string& option, Value& target, const std::map<std::string, Value>& names,
                      const std::string& help) {
    return app_
        .add_option_function<std::string>(
            option, [&target, names](const std::string& name) { target = names.at(name); }, help)
        ->check(CLI::IsMember(names))
        ->group(name_);
  }
  // `parse` is called with the option's name and text. Its InputErrors are reported as the option's.
  template <typename Parse>
  CLI::Option* parsed(const std::string& option, const std::string& type, const std::string& help, const Parse& parse) {
    return app_
        .add_option_function<std::vector<std::string>>(
            option,
            [option, parse](const std::vector<std::string>& texts) {
              try {
                for (const std::string& text : texts) parse(option, text);
              } catch (const InputError& error) {
                throw CLI::ValidationError(option, error.what());
              }
            },
            help)
        ->type_name(type)
        ->expected(1)
        ->group(name_);
  }
  CLI::Option* size(const std::string& option, std::optional<std::array<int, 2>>& target, const std::string& help) {
    return parsed(option, "WxH", help, [&target](const std::string& name, const std::string& text) {
      const std::vector<int> sizes = parse_sizes(name, text, 2, 'x');
      target = {sizes[0], sizes[1]};
    });
  }
  CLI::Option* vector(const std::string& option, std::optional<Vec3>& target, const std::string& help) {
    return parsed(option, "X,Y,Z", help,
                  [&target](const std::string& name, const std::string& text) { target = parse_vector(name, text); });
  }
  CLI::Option* direction(const std::string& option, std::optional<Vec3>& target, const std::string& help) {
    return parsed(option, "X,Y,Z", help, [&target](const std::string& name, const std::string& text) {
      target = parse_vector(name, text);
      if (length(*target) == 0) throw CLI::ValidationError(name, "expected a direction, got " + in_quotes(text));
    });
  }

 private:
  CLI::App& app_;
  std::string name_;
};

}  // namespace gicube::samples
