#include "render/pixel_life.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include "gicube/scene/error.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kColourOne = 4095, kOpacityOne = (1 << 24) - 1, kGradientOne = 511 * 32;  // of the board's words

// Adds the cycle level's events of a ray to its iterations.
void add_events(const std::vector<Json>& events, Json& ray) {
  Json& passes = ray["passes"];
  std::size_t pass = 0;
  int links = 0, overflows = 0;
  for (const Json& event : events) {
    const std::string& what = event.at("event").get_ref<const std::string&>();
    links += what == "linked" ? 1 : 0;
    overflows += what == "overflowed" ? 1 : 0;
    if (what == "filled" && pass > 0) passes[pass - 1]["stalled"] = event.at("count");
    if ((what != "sampled" && what != "leapt") || pass == passes.size()) continue;
    Json& at = passes[pass++];
    at["processor"] = event.at("processor");
    at["cycle"] = event.at("cycle");
    at["missing"] = what == "sampled" ? event.at("count").get<int>() : 0;
    at["stalled"] = 0;
    at["links"] = std::exchange(links, 0);
    at["overflows"] = std::exchange(overflows, 0);
  }
}

std::string place_text(const Json& place, int decimals) {
  return fmt::format("{:.{}f},{:.{}f},{:.{}f}", place[0].get<double>(), decimals, place[1].get<double>(), decimals,
                     place[2].get<double>(), decimals);
}

std::string words_text(const Json& words) {
  return fmt::format("{},{},{}", words[0].get<int>(), words[1].get<int>(), words[2].get<int>());
}

double opacity_of(const Json& pass) { return pass.at("opacity").get<double>() / kOpacityOne; }

std::string pass_line(std::size_t number, const Json& pass) {
  std::string what = fmt::format("leaps {} steps", pass.value("leap", 0));
  if (!pass.contains("leap")) {
    const Json& gradient = pass.at("gradient");
    what = fmt::format("{:9.3f} {:>17} {:>14} {:8.5f}", pass.at("density").get<double>(),
                       fmt::format("{:.2f},{:.2f},{:.2f}", gradient[0].get<double>() / kGradientOne,
                                   gradient[1].get<double>() / kGradientOne, gradient[2].get<double>() / kGradientOne),
                       words_text(pass.at("colour")), opacity_of(pass));
  }
  std::string line = fmt::format("{:4} {:>24} {:>8} {:51} {:>14} {:8.5f}", number, place_text(pass.at("position"), 3),
                                 words_text(pass.at("block")), what, words_text(pass.at("gathered").at("colour")),
                                 opacity_of(pass.at("gathered")));
  if (pass.contains("processor")) {
    line += fmt::format(" {:4} {:9} {:6} {:5} {:5}", pass["processor"].get<int>(), pass["cycle"].get<std::uint64_t>(),
                        pass["missing"].get<int>(), pass["stalled"].get<std::uint64_t>(), pass["links"].get<int>());
  }
  if (pass.value("scattered", false)) line += " scattered";
  return line + '\n';
}

std::string colour_text(const Json& words) {
  std::array<int, 3> bytes{};
  for (std::size_t i = 0; i < 3; ++i)
    bytes[i] = std::min(255, static_cast<int>(words[i].get<int>() * 255 / kColourOne));
  return fmt::format("#{:02x}{:02x}{:02x}", bytes[0], bytes[1], bytes[2]);
}

}  // namespace

Json pixel_life(const std::filesystem::path& events) {
  std::ifstream file(events);
  Json life;
  std::map<std::uint64_t, std::vector<Json>> of_rays, of_last;  // events by ray, since the previous picture
  for (std::string line; std::getline(file, line);) {
    Json event = Json::parse(line);
    if (event.at("event") == "life") {
      life = std::move(event);
      of_last = std::exchange(of_rays, {});
    } else if (!event.contains("carrier")) {
      of_rays[event.at("ray").get<std::uint64_t>()].push_back(std::move(event));
    }
  }
  if (life.is_null()) throw InputError(events.string(), "the events of a picture", "none");
  if (life.contains("refused"))
    throw InputError("--explain-pixel", "a pixel that can be explained", life["refused"].get<std::string>());
  life.erase("event");
  for (Json& ray : life["rays"]) add_events(of_last[ray.at("ray").get<std::uint64_t>()], ray);
  return life;
}

std::string pixel_table(const Json& life) {
  const Json& shown = life.at("framebuffer");
  std::string out = fmt::format("pixel {},{}: red {}, green {}, blue {} of 255, alpha {} of 4095\n",
                                life.at("pixel")[0].get<int>(), life.at("pixel")[1].get<int>(), shown[0].get<int>(),
                                shown[1].get<int>(), shown[2].get<int>(), shown[3].get<int>());
  if (shown != life.at("explained")) {
    out += fmt::format("its rays make another value: {}\n", life.at("explained").dump());
  }
  for (const Json& ray : life.at("rays")) {
    const Json& passes = ray.at("passes");
    out += fmt::format("ray {} at {:.3f},{:.3f}: {} passes, {}\n", ray.at("ray").get<std::uint64_t>(),
                       ray.at("at")[0].get<double>(), ray.at("at")[1].get<double>(), passes.size(),
                       ray.at("end").get<std::string>());
    if (passes.empty()) continue;
    out += fmt::format("{:>4} {:>24} {:>8} {:>9} {:>17} {:>14} {:>8} {:>14} {:>8}", "pass", "x,y,z (voxels)", "block",
                       "density", "gradient", "colour", "opacity", "gathered", "opacity");
    if (passes[0].contains("processor"))
      out += fmt::format(" {:>4} {:>9} {:>6} {:>5} {:>5}", "proc", "cycle", "misses", "waits", "links");
    out += '\n';
    for (std::size_t i = 0; i < passes.size(); ++i) out += pass_line(i, passes[i]);
  }
  return out;
}

std::string pixel_svg(const Json& life) {
  constexpr int kPass = 8, kRow = 24, kLeft = 70, kStrip = 5 * kRow;  // of the drawing, in its units
  std::size_t most = 1;
  for (const Json& ray : life.at("rays")) most = std::max(most, ray.at("passes").size());
  const std::size_t height = life.at("rays").size() * kStrip + kRow;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" "
      "font-size=\"10\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n<text x=\"4\" y=\"14\">pixel "
      "{2},{3}</text>\n",
      kLeft + static_cast<int>(most) * kPass + 8, height, life.at("pixel")[0].get<int>(),
      life.at("pixel")[1].get<int>());
  const auto box = [&out](int x, double y, double tall, const std::string& colour, const std::string& title) {
    out +=
        fmt::format("<rect x=\"{}\" y=\"{:.2f}\" width=\"{}\" height=\"{:.2f}\" fill=\"{}\"><title>{}</title></rect>\n",
                    x, y, kPass - 1, tall, colour, title);
  };
  int top = kRow;
  for (const Json& ray : life.at("rays")) {
    for (const auto& [row, name] : {std::pair{0, "sample"}, {1, "gathered"}, {2, "processor"}, {3, "waits"}}) {
      out += fmt::format("<text x=\"4\" y=\"{}\">{}</text>\n", top + row * kRow + 15, name);
    }
    int x = kLeft;
    for (const Json& pass : ray.at("passes")) {
      const std::string at = place_text(pass.at("position"), 2);
      if (!pass.contains("leap")) {  // as high as it is opaque
        const double tall = 1 + (kRow - 4) * opacity_of(pass);
        box(x, top + kRow - 2 - tall, tall, colour_text(pass.at("colour")),
            fmt::format("{}: density {:.3f}, opacity {:.5f}", at, pass.at("density").get<double>(), opacity_of(pass)));
      }
      const Json& gathered = pass.at("gathered");
      const double tall = 1 + (kRow - 4) * opacity_of(gathered);
      box(x, top + 2 * kRow - 2 - tall, tall, colour_text(gathered.at("colour")),
          fmt::format("{}: opacity {:.5f}", at, opacity_of(gathered)));
      if (pass.contains("processor")) {
        const int processor = pass["processor"].get<int>();
        box(x, top + 2 * kRow + 4, kRow - 8, fmt::format("hsl({},60%,55%)", processor * 137 % 360),
            fmt::format("processor {}, cycle {}", processor, pass["cycle"].get<std::uint64_t>()));
        const double stalled = std::min<double>(kRow - 2, pass["stalled"].get<double>());
        if (stalled > 0)
          box(x, top + 4 * kRow - 2 - stalled, stalled, "#c33",
              fmt::format("{} cycles for {} packets", pass["stalled"].get<int>(), pass["missing"].get<int>()));
      }
      x += kPass;
    }
    top += kStrip;
  }
  return out + "</svg>\n";
}

}  // namespace gicube::samples
