#include "gicube/scene/provenance.h"

#include <OpenImageIO/hash.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

std::string quoted(const std::string& word) {
  const auto plain = [](unsigned char c) {
    return (c < 0x80 && std::isalnum(c) != 0) ||
           std::string_view("_@%+=:,./-").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!word.empty() && std::ranges::all_of(word, plain)) return word;
  if (!is_utf8(word)) {  // JSON and viewers of texts require UTF-8
    std::string text = "$'";
    for (const char c : word) {
      const auto byte = static_cast<unsigned char>(c);
      text += byte < ' ' || byte > '~' || c == '\'' || c == '\\' ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
    }
    return text + "'";
  }
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

}  // namespace

std::vector<std::pair<std::string, std::string>> entries(const Provenance& provenance) {
  std::vector<std::pair<std::string, std::string>> all{
      {"gicube.program", provenance.program},   {"gicube.version", provenance.version},
      {"gicube.command", provenance.command},   {"gicube.config_hash", provenance.config_hash},
      {"gicube.fidelity", provenance.fidelity}, {"gicube.scene_hash", provenance.scene_hash},
  };
  std::erase_if(all, [](const auto& entry) { return entry.second.empty(); });
  return all;
}

std::string command_line(int argc, const char* const* argv) {
  std::string text = argc > 0 ? quoted(std::filesystem::path(argv[0]).filename().string()) : "";
  for (int i = 1; i < argc; ++i) text += ' ' + quoted(argv[i]);
  return text;
}

std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t before) {
  return OIIO::fasthash::fasthash64(bytes.data(), bytes.size(), before);
}

std::string hex(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

}  // namespace gicube::scene
