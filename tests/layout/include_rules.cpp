#include "include_rules.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <sstream>

namespace gicube::layout {
namespace {

// Where the build looks for our headers, and under which folder of the tree they stand.
constexpr std::array<std::string_view, 8> kIncludeFolders{
    "proto",      "driver/include", "driver/hosts/include", "driver/scene/include", "driver",
    "driver/src", "board_emu",      "samples/apps"};

// The part of the ASIC between two FIFOs: knows itself, the records that pass, and the wire.
Rule sibling(std::string_view folder) {
  return {folder, {folder, "board_emu/asic/sim", "board_emu/words", "proto"}, {}};
}

// A room of the board: knows itself and the rooms below it.
Rule room(std::string_view folder, const std::vector<std::string_view>& below,
          const std::vector<std::string_view>& outside = {}) {
  std::vector<std::string_view> ours{folder, "proto"};
  ours.insert(ours.end(), below.begin(), below.end());
  return {folder, ours, outside};
}

// An application: knows itself, what the programs share, and the SDK's public headers; besides it takes what no
// application needs of an SDK: threads, and of gicube-scene whole files and checks of numbers.
Rule program(std::string_view folder, const std::vector<std::string_view>& besides,
             const std::vector<std::string_view>& outside) {
  std::vector<std::string_view> ours{folder,
                                     "samples/apps/scene",
                                     "driver/scene/common",
                                     "driver/scene/include",
                                     "driver/include",
                                     "proto/gicube/fidelity_levels.h",
                                     "proto/gicube/parallel_for.h",
                                     "proto/gicube/unknown_options.h"};
  ours.insert(ours.end(), besides.begin(), besides.end());
  return {folder, ours, outside};
}

bool fits(std::string_view path, std::string_view where) {
  if (!where.ends_with("/*")) {
    return path.starts_with(where) && (where.empty() || path.size() == where.size() || path[where.size()] == '/');
  }
  const std::string_view folder = where.substr(0, where.size() - 1);
  return path.starts_with(folder) && path.find('/', folder.size()) == std::string_view::npos;
}

const Rule* rule_for(std::string_view file) {
  const Rule* best = nullptr;
  for (const Rule& rule : rules()) {
    if (fits(file, rule.where) && (best == nullptr || rule.where.size() > best->where.size())) best = &rule;
  }
  return best;
}

// The file of ours that an include means, as a compiler would find it; empty if none.
std::string find(const Files& files, const std::string& includer, const std::string& name) {
  if (name.starts_with("gicube/v1/") && name.ends_with(".pb.h")) return "proto/" + name;  // generated
  const std::filesystem::path beside = std::filesystem::path(includer).parent_path() / name;
  std::vector<std::string> places{beside.lexically_normal().generic_string(), name};
  for (const std::string_view folder : kIncludeFolders) places.push_back(std::string(folder) + "/" + name);
  const auto place = std::find_if(places.begin(), places.end(), [&](const auto& path) { return files.contains(path); });
  return place == places.end() ? std::string() : *place;
}

bool is_standard(std::string_view name) { return name.find_first_of("./") == std::string_view::npos; }

}  // namespace

const std::vector<Rule>& rules() {
  // clang-format off
  static const std::vector<Rule> table{
      {"proto",              {"proto"}, {}},
      {"proto/gicube/wire/checksum.cpp", {"proto"}, {"isa-l"}},
      {"proto/gicube/registry.cpp", {"proto"}, {"signal.h", "sys/socket.h", "sys/stat.h", "sys/un.h", "unistd.h"}},
      {"proto/gicube/access.cpp", {"proto"}, {"fcntl.h", "sys/stat.h", "unistd.h"}},
      {"proto/gicube/whole_file.cpp", {"proto"}, {"fcntl.h", "sys/stat.h", "unistd.h"}},
      {"proto/gicube/bsdf.h", {}, {"stddef.h", "stdint.h"}},  // C
      {"proto/gicube/observer.h", {}, {"stddef.h", "stdint.h"}},  // C

      // Public headers name nothing but themselves and the standard library, so that applications need nothing else.
      {"driver/include",     {"driver/include"}, {}},
      {"driver/include/gicube/c_api.h", {"driver/include/gicube/c_types.h", "driver/include/gicube/export.h"}, {}},
      {"driver/include/gicube/c_types.h", {}, {"stddef.h", "stdint.h"}},
      {"driver/hosts",       {"driver/hosts", "driver/include"}, {"mpi.h"}},
      {"driver/hosts/include", {"driver/hosts/include", "driver/include"}, {}},
      {"driver/src",         {"driver", "proto/gicube/wire", "proto/gicube/access.h", "proto/gicube/archive.h",
        "proto/gicube/fidelity_levels.h", "proto/gicube/parallel_for.h", "proto/gicube/registry.h",
        "proto/gicube/whole_file.h"}, {kAnything}},
      {"driver/src/c_api",   {"driver/src/c_api", "driver/src/encode/argument.h", "driver/src/transport/event.h",
                              "driver/include"}, {"fmt"}},
      {"driver/src/encode",  {"driver/src/encode", "driver/include", "proto/gicube/parallel_for.h",
        "proto/gicube/wire"}, {"fmt"}},

      // The board's rooms, from the ground up.
      room("board_emu/words", {}),
      {"board_emu/box", {"board_emu/box", "board_emu/words"}, {kAnything}},
      // Starts the processes of plug-ins.
      room("board_emu/plug_ins", {"board_emu/words"},
           {"fcntl.h", "linux/futex.h", "poll.h", "signal.h", "spawn.h", "string.h", "sys/mman.h", "sys/socket.h",
            "sys/syscall.h", "sys/types.h", "sys/wait.h", "time.h", "unistd.h"}),
      // The program in which they run: nothing of the board but the memory of the calls.
      {"board_emu/plug_ins/host",
       {"board_emu/plug_ins/host", "board_emu/plug_ins/call_memory.h", "board_emu/box/box.h", "proto/gicube/bsdf.h",
         "proto/gicube/observer.h"},
       {"dlfcn.h", "linux/capability.h", "poll.h", "signal.h", "sys/mman.h", "sys/prctl.h", "sys/signalfd.h",
        "sys/socket.h", "sys/stat.h", "sys/syscall.h", "sys/wait.h", "unistd.h"}},
      // What a memory device holds decides how large a volume may be.
      room("board_emu/config", {"board_emu/words", "board_emu/asic/fifo_places.h", "board_emu/asic/memory_standards.h"},
        {"fmt", "google/protobuf"}),
      room("board_emu/memory", {"board_emu/words", "board_emu/config"}, {"hwy", "sys/mman.h"}),
      room("board_emu/datapath", {"board_emu/words", "board_emu/config", "board_emu/memory"}, {"emmintrin.h"}),
      // Siblings on a ray's way do not know each other.
      sibling("board_emu/asic/*"),
      room("board_emu/asic/memory_standards.h", {"board_emu/asic/dram"}),
      room("board_emu/asic/memory_standards.cpp",
           {"board_emu/asic/memory_standards.h", "board_emu/asic/dram", "board_emu/asic/rdram", "board_emu/asic/ddr"}),
      sibling("board_emu/asic/sim"),
      sibling("board_emu/asic/raybus"),
      room("board_emu/asic/sorter", {"board_emu/words", "board_emu/asic/sim", "board_emu/asic/fifo_places.h"}),
      sibling("board_emu/asic/cache"),
      // What memory standards share, and each of them.
      sibling("board_emu/asic/dram"),
      room("board_emu/asic/rdram", {"board_emu/asic/dram", "board_emu/asic/sim", "board_emu/words"}),
      room("board_emu/asic/ddr", {"board_emu/asic/dram", "board_emu/asic/sim", "board_emu/words"}),
      sibling("board_emu/asic/link"),
      room("board_emu/levels", {"board_emu/words", "board_emu/config", "board_emu/memory", "board_emu/datapath"}),
      room("board_emu/functional",
           {"board_emu/words", "board_emu/memory", "board_emu/datapath", "board_emu/levels"}, {"hwy"}),
      // Its tasks are the levels', its memory is built as the ASIC's.
      room("board_emu/dsp", {"board_emu/words", "board_emu/config", "board_emu/asic/dram", "board_emu/levels"}),
      // Has values that nobody sees on their way from the level without time; the others are those of these headers.
      room("board_emu/cycle",
           {"board_emu/words", "board_emu/config", "board_emu/asic", "board_emu/dsp", "board_emu/levels",
            "board_emu/functional/functional_trace.h", "board_emu/functional/simd/simd_tracer.h",
            "board_emu/datapath/bricks.h", "board_emu/datapath/frame.h", "board_emu/datapath/interaction.h",
            "board_emu/datapath/opacity_correction.h", "board_emu/datapath/ray_step.h", "board_emu/datapath/shade.h"}),
      // Commands name no level; one file does.
      room("board_emu/firmware", {"board_emu/words", "board_emu/config", "board_emu/memory", "board_emu/datapath",
                                  "board_emu/asic", "board_emu/levels"}),
      room("board_emu/firmware/make_level.cpp",
           {"board_emu/firmware", "board_emu/words", "board_emu/levels", "board_emu/functional", "board_emu/cycle"}),
      room("board_emu/firmware/routines", {"board_emu/firmware", "board_emu/plug_ins", "board_emu/words",
        "board_emu/datapath"}),
      room("board_emu/board", {"board_emu/words", "board_emu/config", "board_emu/memory", "board_emu/levels",
                               "board_emu/firmware"}, {"fmt", "google/protobuf"}),
      // Watches the whole machine, and is watched by none of its parts.
      room("board_emu/observe", {"board_emu/words", "board_emu/plug_ins", "board_emu/asic", "board_emu/cycle",
        "board_emu/board",
                                 "board_emu/firmware/pixel_life.h", "board_emu/config/energy.h", "board_emu/datapath",
                                   "board_emu/levels"}, {"fmt"}),
      {"board_emu/server",   {"board_emu/server", "board_emu/words", "board_emu/box/box.h", "board_emu/board/board.h",
        "board_emu/board/checkpoint.h", "board_emu/config/config.h", "board_emu/config/textproto_reader.h",
                              "board_emu/config/hardware_cost.h",
                              "board_emu/firmware/routines/routine_table.h", "board_emu/observe/observation.h",
                                "proto"},
                             {kAnything}},

      // gicube-scene: an application of the driver's public headers; its own name those and the standard library alone.
      {"driver/scene/include", {"driver/scene/include", "driver/include"}, {}},
      {"driver/scene",       {"driver/scene", "driver/include", "proto/gicube/v1/scene.pb.h"}, {"fmt", "OpenImageIO"}},
      {"driver/scene/pictures", {"driver/scene/pictures", "driver/scene/formats/pictures/picture_library.h",
        "driver/scene/formats/stored_samples.h"}, {"OpenImageIO", "tiffio.h"}},
      {"driver/scene/libraries", {"driver/scene/libraries", "driver/scene/formats/volume_library.h"}, {"dcmtk", "fmt",
        "hdf5.h", "openvdb"}},
      {"driver/scene/common", {"driver/scene/common", "driver/scene/include", "driver/include",
        "proto/gicube/parallel_for.h", "proto/gicube/whole_file.h"},
                             {"dlfcn.h", "fmt", "google/protobuf", "unistd.h"}},
      {"driver/scene/formats", {"driver/scene/formats", "driver/scene/common", "driver/scene/include",
        "driver/include"},
                             {"bzlib.h", "dlfcn.h", "fcntl.h", "fmt", "locale.h", "minizip", "nifti2_io.h", "png.h",
                               "pugixml.hpp", "sys", "teem", "unistd.h",
                              "zlib.h"}},
      // Solids, meshes and their voxels know neither the scene that they stand in nor its file.
      {"driver/scene/geometry", {"driver/scene/geometry", "driver/scene/buckyball.h", "driver/scene/common",
                              "driver/scene/formats/header_lines.h", "driver/scene/formats/stored_samples.h",
                              "driver/scene/include/gicube/scene/affine.h", "driver/scene/include/gicube/scene/error.h",
                              "driver/scene/include/gicube/scene/hypertexture.h",
                                "driver/scene/include/gicube/scene/mesh.h", "driver/scene/include/gicube/scene/shape.h",
                              "driver/scene/include/gicube/scene/volume_file.h",
                              "driver/scene/include/gicube/scene/voxeliser.h", "driver/include"}, {"fmt", "glm"}},
      {"driver/scene/graph", {"driver/scene", "driver/include", "proto/gicube/v1/scene.pb.h"},
                             {"fmt", "google/protobuf"}},

      // The Python package: an application of the public headers.
      {"driver/python/core",  {"driver/python/core", "driver/include", "driver/hosts/include", "driver/scene/include"},
        {"cxxabi.h", "pybind11", "unistd.h"}},

      program("samples/apps/scene", {"proto/gicube/v1/board_config.pb.h"}, {kAnything}),
      {"samples/short",            {"samples/short", "driver/include"},
        {"poll.h", "spawn.h", "sys/wait.h", "unistd.h"}},
      {"samples/small/hello",      {"samples/small/hello", "driver/include"}, {}},
      {"samples/small/host_bsdf",  {"samples/small/host_bsdf", "driver/include"}, {}},
      // Plain C, for the board and not for the driver.
      {"samples/small/bsdf_plugin", {"samples/small/bsdf_plugin", "proto/gicube/bsdf.h"}, {"math.h", "stdio.h"}},
      // Like applications; besides in the management plane's messages, and looks for boards as the driver does.
      {"driver/tools/smi",          {"driver/tools/smi", "driver/include", "driver/src/transport",
        "proto/gicube/v1/management.pb.h",
                              "proto/gicube/v1/management.grpc.pb.h", "proto/gicube/v1/board_config.pb.h",
                                "proto/gicube/access.h", "proto/gicube/registry.h",
                              "proto/gicube/unknown_options.h", "proto/gicube/whole_file.h"},
                             {kAnything}},
      // Speaks the bus below the driver's public headers.
      {"driver/tools/replay",       {"driver/tools/replay", "driver/include", "driver/src", "proto/gicube/wire",
        "proto/gicube/unknown_options.h", "proto/gicube/whole_file.h"}, {kAnything}},
      {"driver/tools/conformance",  {"driver/tools/conformance", "driver/include", "driver/src", "proto/gicube/wire",
        "proto/gicube/unknown_options.h", "proto/gicube/whole_file.h"}, {kAnything}},
      // Carries a driver's bytes, and connects as a driver does; reads no frame.
      {"driver/tools/pci",          {"driver/tools/pci", "driver/include/gicube/error.h", "driver/src/transport",
        "proto/gicube/wire/pci_config.h",
                              "proto/gicube/wire/pci_function.h", "proto/gicube/unknown_options.h"}, {kAnything}},
      program("samples/studies", {}, {kAnything}),
      // Outside applications, which know the installed headers only; C too.
      {"samples/installed",  {"samples/installed", "driver/include", "driver/scene/include"},
                             {"stdint.h", "stdio.h", "stdlib.h", "string.h"}},
      // The methods know neither files nor the program.
      {"samples/apps/cone_beam",  {"samples/apps/cone_beam/*", "samples/apps/scene/names.h",
        "proto/gicube/parallel_for.h", "driver/include"},
                             {"fmt", "fftw3.h"}},
      {"samples/apps/cone_beam/phantom", {"samples/apps/cone_beam/phantom", "samples/apps/cone_beam/*",
        "samples/apps/scene/names.h",
                              "proto/gicube/parallel_for.h", "driver/include"}, {"fmt"}},
      {"samples/apps/cone_beam/plan", {"samples/apps/cone_beam/plan", "samples/apps/cone_beam/phantom",
        "samples/apps/cone_beam/*",
                              "driver/include"}, {"fmt"}},
      // Projections are read by the parts that read volumes.
      program("samples/apps/cone_beam/scan", {"samples/apps/cone_beam/*", "driver/scene/formats",
        "proto/gicube/v1/cone_scan.pb.h"},
              {"fmt", "google/protobuf", "nlohmann", "OpenImageIO", "pugixml.hpp"}),
      program("samples/apps/cone_beam/program", {"samples/apps/cone_beam"}, {kAnything}),
      // Its files are read by the parts that read scenes.
      program("samples/apps/compose", {"driver/scene/graph/graph_reader.h", "proto/gicube/v1/composition.pb.h",
        "samples/apps/meshes"},
              {"fmt"}),
      program("samples/apps/compose/program", {"samples/apps/compose", "samples/apps/meshes"}, {kAnything}),
      program("samples/apps/meshes", {}, {"embree3", "fmt"}),
      program("samples/apps/form_factors/exchange", {"samples/apps/form_factors/radiosity/radiosity.h"},
        {"boost", "fmt"}),
      program("samples/apps/form_factors/radiosity", {"samples/apps/form_factors/exchange"}, {"fmt"}),
      program("samples/apps/form_factors/plan", {"samples/apps/form_factors/radiosity"}, {"fmt"}),
      program("samples/apps/form_factors", {}, {kAnything}),
      // Paths of light know neither files nor the program.
      program("samples/apps/light/transport", {}, {"fmt"}),
      program("samples/apps/light/path", {"samples/apps/light/transport"}, {}),
      program("samples/apps/light/photon_map", {"samples/apps/light/transport"}, {}),
      program("samples/apps/light/photon_map/photon_tree.cpp",
        {"samples/apps/light/transport", "samples/apps/light/photon_map"}, {"nanoflann.hpp"}),
      program("samples/apps/light/program", {"samples/apps/light"}, {kAnything}),
      program("samples/apps/render", {"driver/hosts/include"}, {kAnything}),
      // Has gicube-render's parts make its pictures, and asks the board's process beside the driver.
      program("samples/apps/view", {"samples/apps/render", "proto/gicube/access.h", "proto/gicube/guests.h",
        "proto/gicube/registry.h", "proto/gicube/v1/management.pb.h"}, {kAnything}),
  };
  // clang-format on
  return table;
}

std::vector<std::string> faults(const Files& files, const std::string& file, std::string_view text) {
  static const std::regex kInclude(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"].*)");
  const Rule* rule = rule_for(file);
  if (rule == nullptr) return {file + ": no rule says what this folder may include (tests/layout/include_rules.cpp)"};

  std::vector<std::string> found;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch match;
    if (!std::regex_match(line, match, kInclude)) continue;
    const std::string name = match[2];
    const std::string target = find(files, file, name);
    const std::string start = file + ":" + std::to_string(number) + ": ";
    const auto allows = [](const auto& list, std::string_view path) {
      return std::any_of(list.begin(), list.end(), [path](std::string_view where) { return fits(path, where); });
    };
    if (!target.empty()) {
      if (!allows(rule->ours, target)) found.push_back(start + std::string(rule->where) + " may not include " + target);
    } else if (match[1] == "\"") {
      found.push_back(start + "no file of ours is called " + name);
    } else if (!is_standard(name) && !allows(rule->outside, name)) {
      found.push_back(start + std::string(rule->where) + " may not include <" + name + ">");
    }
  }
  return found;
}

}  // namespace gicube::layout
