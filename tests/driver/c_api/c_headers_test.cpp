// gicube/c_types.h holds the fields of the C++ headers and the values of their enumerations, by name. The headers are read as text, so
// that a field which somebody adds to one of them alone is found.
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

using Names = std::set<std::string>;

std::string header(const std::string& name) {
  std::ifstream file(GICUBE_SOURCE_DIR "/driver/include/gicube/" + name);
  EXPECT_TRUE(file) << name;
  std::stringstream text;
  text << file.rdbuf();
  const std::string plain = std::regex_replace(text.str(), std::regex(R"(//[^\n]*|\n#[^\n]*)"), "\n");
  return std::regex_replace(plain, std::regex(R"(/\*([^*]|\*+[^*/])*\*+/)"), " ");
}

// What stands between the braces of the first `begin`, without what stands in braces within: member functions, default values.
std::string body(const std::string& text, const std::string& begin) {
  std::smatch found;
  if (!std::regex_search(text, found, std::regex(begin + R"([^;{]*\{)"))) return "";
  std::string inside;
  int depth = 1;
  for (const char each : found.suffix().str()) {
    if (each == '}' && --depth == 0) break;
    if (depth == 1 && each != '}') inside += each;
    if (each == '{' && depth++ == 1) inside.pop_back();
  }
  return inside;
}

// double colour[3], low = 0; -> colour, low
Names fields(const std::string& header_name, const std::string& record) {
  std::stringstream statements(body(header(header_name), R"(struct (GICUBE_API )?)" + record + R"(\b)"));
  Names names;
  for (std::string statement; std::getline(statements, statement, ';');) {
    if (statement.find('(') != std::string::npos) continue;
    for (std::string less; less != statement;) {
      less = statement;
      statement = std::regex_replace(statement, std::regex("<[^<>]*>"), " ");
    }
    std::stringstream declarators(statement);
    for (std::string each; std::getline(declarators, each, ',');) {
      std::smatch name;
      if (std::regex_search(each, name, std::regex(R"((\w+)\s*(\[\w+\]\s*)?(=|$))"))) names.insert(name[1]);
    }
  }
  EXPECT_FALSE(names.empty()) << record << " in " << header_name;
  return names;
}

struct Match {
  std::string header;
  std::vector<std::string> records;                       // of C++, which one of C holds together
  std::map<std::string, std::vector<std::string>> other;  // fields of C++ that are named otherwise in C, or are several
  Names own;                                              // fields of C alone
};

const std::map<std::string, Match>& matches() {
  static const std::map<std::string, Match> table{
      {"gicube_open_options",
       {"board.h",
        {"OpenOptions"},
        {{"watchdog", {"watchdog_ms"}}, {"wait_for_board", {"wait_for_board_ms"}}, {"while_waiting", {}}, {"log", {}}},
        {"reserved_too"}}},
      {"gicube_reopened", {"board.h", {"Reopened"}, {}, {}}},
      {"gicube_board_info", {"board.h", {"BoardInfo"}, {}, {}}},
      {"gicube_volume",
       {"volume.h",
        {"VolumeView"},
        {{"samples", {"samples", "sample_bytes"}},
         {"range", {"has_range", "low", "high"}},
         {"gradients", {"gradients", "gradient_count"}},
         {"tags", {"tags", "tag_count"}},
         {"colours", {"colours", "colour_bytes"}}},
        {}}},
      {"gicube_colour_point", {"transfer_function.h", {"ColourPoint"}, {}, {}}},
      {"gicube_opacity_point", {"transfer_function.h", {"OpacityPoint"}, {}, {}}},
      {"gicube_shading", {"shading.h", {"Phong", "Shading"}, {{"phong", {}}}, {}}},
      {"gicube_material", {"material.h", {"Material"}, {{"parameters", {"parameters", "parameter_count"}}}, {}}},
      {"gicube_scatter_event",
       {"scattering.h", {"ScatterEvent"}, {{"parameters", {"parameters", "parameter_count"}}}, {}}},
      {"gicube_scatter_answer", {"scattering.h", {"ScatterAnswer"}, {}, {}}},
      {"gicube_light",
       {"illumination.h",
        {"PointLight", "DirectionalLight", "RectangleLight", "SphereLight"},
        {{"towards", {"position"}}, {"corner", {"position"}}, {"centre", {"position"}}, {"irradiance", {"power"}}},
        {"kind"}}},
      {"gicube_illumination",
       {"illumination.h", {"Illumination"}, {{"light_colours", {"light_colours", "light_colour_count"}}}, {}}},
      {"gicube_light_energy", {"illumination.h", {"LightEnergy"}, {}, {}}},
      {"gicube_lighting_report", {"illumination.h", {"LightingReport"}, {}, {}}},
      {"gicube_batch_lighting", {"illumination.h", {"LightingReport"}, {{"escaped_by_face", {}}, {"colours", {}}}, {}}},
      {"gicube_cut_plane", {"view.h", {"CutPlane"}, {}, {}}},
      {"gicube_lamp", {"view.h", {"Lamp"}, {}, {}}},
      {"gicube_view",
       {"view.h",
        {"View"},
        {{"cut_planes", {"cut_planes", "cut_plane_count"}}, {"lamps", {"lamps", "lamp_count"}}},
        {}}},
      {"gicube_pixel", {"image.h", {"Pixel"}, {}, {}}},
      {"gicube_host_ray", {"ray.h", {"HostRay"}, {}, {}}},
      {"gicube_traced_ray", {"ray.h", {"TracedRay"}, {}, {}}},
      {"gicube_ray_request", {"ray.h", {"RayRequest"}, {{"sampling", {"sampled_as"}}}, {}}},
      {"gicube_deposit_report", {"ray.h", {"DepositReport"}, {}, {}}},
      {"gicube_batch_report",
       {"ray.h",
        {"BatchReport"},
        {{"completed", {"completed_ps"}},
         {"lighting", {"deposited", "lighting", "escaped_by_face"}},
         {"deposits", {"backprojected", "deposits"}}},
        {"rays"}}},
      {"gicube_box", {"volume.h", {"VoxelBox"}, {}, {"size"}}},
      {"gicube_element", {"pair.h", {"Element"}, {}, {}}},
      {"gicube_element_pair", {"pair.h", {"ElementPair"}, {}, {}}},
      {"gicube_pair_request", {"pair.h", {"PairRequest"}, {}, {}}},
      {"gicube_pair_factor", {"pair.h", {"PairFactor"}, {}, {}}},
  };
  return table;
}

TEST(CHeader, RecordsHaveTheFieldsOfTheCppOnes) {
  for (const auto& [record, match] : matches()) {
    Names expected = match.own;
    for (const std::string& each : match.records) {
      for (const std::string& field : fields(match.header, each)) {
        const auto other = match.other.find(field);
        if (other == match.other.end()) {
          expected.insert(field);
        } else {
          expected.insert(other->second.begin(), other->second.end());
        }
      }
    }
    Names found = fields("c_types.h", record);
    if (!expected.contains("size")) found.erase("size");
    found.erase("reserved");
    EXPECT_EQ(found, expected) << record;
  }
}

TEST(CHeader, EveryRecordHasACppOne) {
  const std::string text = header("c_types.h");
  const std::regex record(R"(struct (gicube_\w+) \{)");
  int count = 0;
  for (std::sregex_iterator each(text.begin(), text.end(), record), end; each != end; ++each, ++count) {
    const std::string name = (*each)[1];
    const bool is_of_c =
        name == "gicube_ray_span" || name == "gicube_polyline";  // a std::span of C++; one of 0.2 alone
    EXPECT_TRUE(matches().contains(name) || is_of_c) << name;
  }
  EXPECT_EQ(count, static_cast<int>(matches().size()) + 2);
}

// "double eye[3]" and so on, in their order. A reserved field may get a name, but no other type.
std::vector<std::string> declarations(const std::string& header_name, const std::string& record) {
  std::stringstream statements(body(header(header_name), "struct " + record + R"(\b)"));
  std::vector<std::string> out;
  for (std::string each; std::getline(statements, each, ';');) {
    each = std::regex_replace(each, std::regex(R"(\s+)"), " ");
    if (each != " ") out.push_back(each);
  }
  return out;
}

TEST(CHeader, RecordsBeginWithTheFieldsOfPastReleases) {
  const std::string past = "../../../tests/driver/c_api/released/0.2.0/gicube/c_types.h";
  const std::string text = header(past);
  const std::regex begin(R"(struct (gicube_\w+) \{)");
  int count = 0;
  for (std::sregex_iterator each(text.begin(), text.end(), begin), end; each != end; ++each, ++count) {
    const std::string name = (*each)[1];
    const auto before = declarations(past, name), now = declarations("c_types.h", name);
    ASSERT_GE(now.size(), before.size()) << name;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const bool has_a_name_now = before[i].ends_with(" reserved") && now[i].starts_with(before[i].substr(0, 8));
      EXPECT_TRUE(has_a_name_now || now[i] == before[i]) << name << ": " << now[i] << " for " << before[i];
    }
    const bool may_grow = before[0] == " uint32_t size" && name != "gicube_batch_lighting";
    EXPECT_TRUE(may_grow || now.size() == before.size()) << name << " stands in arrays";
  }
  EXPECT_EQ(count, 29);
}

// kByBoard -> BY_BOARD
std::string in_capitals(const std::string& enumerator) {
  std::string out;
  for (const char each : enumerator.substr(1)) {
    if (std::isupper(static_cast<unsigned char>(each)) != 0 && !out.empty()) out += '_';
    out += static_cast<char>(std::toupper(static_cast<unsigned char>(each)));
  }
  return out;
}

TEST(CHeader, EnumerationsHaveTheNamesAndValuesOfTheCppOnes) {
  const std::string c = header("c_types.h");
  for (const auto& [prefix, file, name] : std::vector<std::array<std::string, 3>>{
           {"GICUBE_BACK_PRESSURE_", "board.h", "BackPressure"},
           {"GICUBE_FIDELITY_", "board.h", "Fidelity"},
           {"GICUBE_LOSS_", "error.h", "Loss"},
           {"GICUBE_SAMPLE_", "volume.h", "SampleType"},
           {"GICUBE_BSDF_", "material.h", "Bsdf"},
           {"GICUBE_ALBEDO_", "illumination.h", "Albedo"},
           {"GICUBE_RULES_", "illumination.h", "EnergyRules"},
           {"GICUBE_FILTER_", "view.h", "PixelFilter"},
           {"GICUBE_RAY_", "ray.h", "RayType"},
           {"GICUBE_WORDS_", "ray.h", "SumWords"},
           {"GICUBE_ELEMENT_", "pair.h", "ElementKind"},
           {"GICUBE_PAIR_RAYS_", "pair.h", "PairRays"},
       }) {
    std::map<std::string, int> expected, found;
    const std::string cpp = body(header(file), "enum class " + name + R"(\b)");
    EXPECT_EQ(cpp.find('='), std::string::npos) << name << ": its values are not 0, 1, 2 ...";
    const std::regex enumerator(R"(\bk\w+)");
    for (std::sregex_iterator each(cpp.begin(), cpp.end(), enumerator), end; each != end; ++each) {
      expected.emplace(in_capitals(each->str()), static_cast<int>(expected.size()));
    }
    const std::regex value("\\b" + prefix + R"((\w+) = (\d+))");  // the -1 of GICUBE_LOSS_NONE is C's alone
    for (std::sregex_iterator each(c.begin(), c.end(), value), end; each != end; ++each) {
      found.emplace((*each)[1], std::stoi((*each)[2]));
    }
    if (name == "BackPressure") {  // C has no exceptions to throw
      expected.erase("THROW");
      expected.emplace("FAIL", 1);
    }
    EXPECT_FALSE(expected.empty()) << name;
    EXPECT_EQ(found, expected) << name;
  }
}

}  // namespace
