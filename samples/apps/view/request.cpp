#include "view/request.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/names.h"

namespace gicube::samples::view {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxId = std::uint64_t{1} << 53;  // the integers that JavaScript represents exactly
constexpr std::size_t kMaxSettings = 64;                  // chosen: gicube-render has fewer options
constexpr std::size_t kMaxNames = 8192;                   // chosen: slices of a folder
constexpr std::size_t kMaxNameBytes = 200;                // chosen: below what file systems take

const std::map<std::string, Request::Kind>& kinds() {
  using enum Request::Kind;
  static const std::map<std::string, Request::Kind> all{
      {"picture", kPicture}, {"slice", kSlice},     {"histogram", kHistogram}, {"open", kOpen},
      {"machine", kMachine}, {"compare", kCompare}, {"board", kBoard}};
  return all;
}

const json& member(const json& message, const char* name, bool (json::*is)() const, const char* expected) {
  const auto found = message.find(name);
  if (found == message.end()) throw InputError(name, expected, "none");
  if (!((*found).*is)()) throw InputError(name, expected, found->type_name());
  return *found;
}

std::string text_in(const json& message, const char* name) {
  return member(message, name, &json::is_string, "a text").get<std::string>();
}

bool flag_in(const json& message, const char* name) {
  return member(message, name, &json::is_boolean, "true or false").get<bool>();
}

std::uint64_t number_in(const json& message, const char* name, std::uint64_t most) {
  const json& number = member(message, name, &json::is_number_unsigned, "a whole number");
  const auto value = number.get<std::uint64_t>();
  if (value > most) throw InputError(name, "at most " + std::to_string(most), std::to_string(value));
  return value;
}

Settings settings_in(const json& message, const char* name) {
  const json& object = member(message, name, &json::is_object, "an object of settings");
  if (object.size() > kMaxSettings)
    throw InputError(name, "at most " + std::to_string(kMaxSettings) + " settings", std::to_string(object.size()));
  Settings settings;
  for (const auto& [key, value] : object.items()) {
    if (!value.is_string()) throw InputError(key, "a text", value.type_name());
    settings[key] = value.get<std::string>();
  }
  return settings;
}

std::vector<std::string> names_in(const json& message) {
  const json& array = member(message, "names", &json::is_array, "a list of names");
  if (array.empty() || array.size() > kMaxNames)
    throw InputError("names", "1 to " + std::to_string(kMaxNames) + " names", std::to_string(array.size()));
  std::vector<std::string> names;
  for (const json& name : array) {
    if (!name.is_string() || !is_file_name(name.get_ref<const std::string&>()))
      throw InputError("names", "names of posted files", "something else");
    names.push_back(name.get<std::string>());
  }
  return names;
}

int axis_in(const json& message) {
  const std::string name = text_in(message, "axis");
  const std::size_t axis = name.size() == 1 ? std::string_view("xyz").find(name) : std::string_view::npos;
  if (axis == std::string_view::npos) throw InputError("axis", "x, y or z", in_quotes(name));
  return static_cast<int>(axis);
}

Request::Projection projection_in(const json& message) {
  using enum Request::Projection;
  if (!message.contains("projection")) return kNone;
  const std::string name = text_in(message, "projection");
  if (name == "max") return kMaximum;
  if (name == "mean") return kMean;
  throw InputError("projection", "max or mean", in_quotes(name));
}

}  // namespace

bool is_file_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxNameBytes && name.front() != '.' && std::ranges::none_of(name, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return c == '/' || byte < 0x20 || byte == 0x7f;
  });
}

Request parse_request(std::string_view text) {
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) throw InputError("message", "a JSON object", "something else");
  const std::string what = text_in(message, "do");
  const auto kind = kinds().find(what);
  if (kind == kinds().end()) throw InputError("do", "a request of protocol.h", in_quotes(what));
  Request request;
  request.kind = kind->second;
  using enum Request::Kind;
  if (request.kind == kPicture || request.kind == kSlice || request.kind == kCompare)
    request.id = number_in(message, "id", kMaxId);
  if (request.kind == kPicture) {
    request.on = flag_in(message, "moving");
    request.projection = projection_in(message);
  }
  if (request.kind == kMachine) request.on = flag_in(message, "on");
  if (request.kind == kPicture || request.kind == kCompare) request.settings = settings_in(message, "settings");
  if (request.kind == kCompare) request.other = settings_in(message, "other");
  if (request.kind == kOpen) request.names = names_in(message);
  if (request.kind == kSlice) {
    request.axis = axis_in(message);
    request.at = static_cast<int>(number_in(message, "at", std::numeric_limits<int>::max()));
  }
  return request;
}

}  // namespace gicube::samples::view
