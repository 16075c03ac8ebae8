#include "cone_beam/program/options.h"

#include <fmt/format.h>

#include <numbers>
#include <ostream>
#include <regex>

#include "cone_beam/program/statistics.h"
#include "cone_beam/scan/scan.h"
#include "cone_beam/scan/scan_file.h"
#include "scene/formats/header_lines.h"
#include "scene/formats/volume_output.h"
#include "scene/program/input_error.h"
#include "scene/program/option_group.h"

namespace gicube::samples {
namespace {

const char* const kFooter =
    "Exit codes: 0 done, 1 failed, 2 wrong usage. Method, formats, limits, figures: docs/guide/cone_beam.md.";
const char* const kPhantoms = "builtin:shepp-logan, builtin:shepp-logan-high-contrast, builtin:sphere";

const CLI::Range kSteps(1.0 / 64, 16.0), kCounts(2, 100'000), kShares(0.0, 1.0);

CLI::ValidationError expected(const std::string& option, const char* what, const std::string& text) {
  return CLI::ValidationError(option, fmt::format("expected {}, got {}", what, in_quotes(text)));
}

void add_object(CLI::App& app, ObjectOptions& object, const std::string& name, const std::string& what) {
  app.add_option(name, object.name, what + ": " + kPhantoms + ", or a volume file (.nrrd .mhd .mha .nii)")->required();
  OptionGroup group(app, "Options");
  group.number("--radius", object.radius, CLI::PositiveNumber, "of a phantom, in the scan's unit");
  app.add_option("--value", object.value, "of the sphere; times a head's values: 0.02 a mm is about water's")
      ->capture_default_str();
}

void add_volume(CLI::App& app, ScanOptions& scan) {
  OptionGroup group(app, "Volume");
  group.parsed("--size", "X,Y,Z", "voxels (the scan's; else what the detector sees)",
               [&scan](const std::string& name, const std::string& text) {
                 const std::vector<int> sizes = parse_sizes(name, text, 3, ',');
                 scan.size = Dims{sizes[0], sizes[1], sizes[2]};
               });
  group.parsed("--spacing", "EDGE|X,Y,Z", "edges of a voxel (the scan's; else a pixel's seen at the axis)",
               [&scan](const std::string& name, const std::string& text) {
                 const bool three = text.find(',') != std::string::npos;
                 std::vector<double> edges = parse_numbers(name, text, three ? 3 : 1);
                 edges.resize(3, edges[0]);
                 for (const double edge : edges) {
                   if (!(edge > 0)) throw expected(name, "numbers above 0", text);
                 }
                 scan.spacing = {edges[0], edges[1], edges[2]};
               });
}

void add_input(CLI::App& app, ScanOptions& scan) {
  app.add_option("SCAN", scan.input,
                 "a scan file (protobuf text), a .json of CTSimU, or a folder of plastimatch's projection matrices")
      ->required();
  app.add_option("--projections", scan.projections,
                 "files of views in place of the scan's: .nrrd .mhd .mha .nii .pfm .tif, a folder of images, or raw")
      ->type_name("FILE...")
      ->group("Scan");
  OptionGroup(app, "Scan")
      .parsed("--type", "NAME", "of raw --projections: uint8 uint16 int16 float32, little-endian",
              [&scan](const std::string& name, const std::string& text) {
                scan.type = raw_type(text);
                if (!scan.type) throw expected(name, "uint8, uint16, int16 or float32", text);
              });
}

void add_own_scan(CLI::App& app, ScanOptions& scan) {
  OptionGroup group(app, "Scan");
  group
      .file("--scan", scan.input,
            "whose geometry is taken: as SCAN of reconstruct; without it these options describe one")
      ->type_name("SCAN");
  group.parsed("--detector", "WxH", "pixels (256x256)", [&scan](const std::string& option, const std::string& text) {
    const std::vector<int> sizes = parse_sizes(option, text, 2, 'x');
    scan.detector_size = {sizes[0], sizes[1]};
  });
  group.number("--pitch", scan.pitch, CLI::PositiveNumber, "of the pixels");
  group.number("--source-to-axis", scan.source_to_axis, CLI::PositiveNumber, "distance");
  group.number("--source-to-detector", scan.source_to_detector, CLI::PositiveNumber, "distance");
  group.number("--views", scan.views, kCounts, "evenly over the arc");
  group.number("--arc", scan.arc, CLI::Range(1.0, 360.0), "degrees");
}

void add_fdk(CLI::App& app, FdkSettings& fdk) {
  OptionGroup group(app, "FDK");
  fdk.rays = 0;
  fdk.normalise = true;
  group.choice("--window", fdk.window, kWindows, "of the ramp filter: ram-lak, shepp-logan or hann (ram-lak)");
  group.number("--rays", fdk.rays, CLI::Range(0, 4),
               "a pixel's, along each detector axis; 0: so many that they lie no more than 1.25 voxels apart");
  group.number("--sharpen", fdk.sharpen, CLI::Range(0.0, 0.25),
               "against the blur of splatting: what a voxel takes from each neighbour");
  group.flag("--normalise,!--no-normalise", fdk.normalise,
             "divide out the ripples of rays that lie unevenly against voxels; sends every ray twice (on)");
  group.choice("--accumulator", fdk.accumulator, kAccumulators,
               "words on the board: sums (signed, 36 bits) or irradiance (the paper's, in two passes) (sums)");
  group.number("--read-every", fdk.read_every, CLI::Range(1, 100'000), "views, with --accumulator irradiance");
  group.number("--bits", fdk.bits, CLI::Range(0, 32), "of irradiance words that are used; 0: all");
  group.number("--headroom", fdk.headroom, CLI::PositiveNumber,
               "what full irradiance words stand for, over a bound of what a voxel can get; less is finer, and clips");
}

void add_algebraic(CLI::App& app, AlgebraicSettings& settings) {
  OptionGroup group(app, "SART, OS-SART, SIRT");
  group.number("--iterations", settings.iterations, CLI::Range(1, 10'000), "at most, each through all views");
  group.number("--subsets", settings.subsets, kCounts, "of views, each corrected for at once; os-sart");
  group.number("--relaxation", settings.relaxation, CLI::PositiveNumber, "of a correction; beyond 2 it diverges");
  group.choice("--order", settings.order, kViewOrders,
               "of the views or subsets: sequential, random or golden (golden)");
  app.add_flag_callback(
         "--allow-negative", [&settings] { settings.non_negative = false; }, "keep values below 0")
      ->group("SART, OS-SART, SIRT");
  group.number("--stop", settings.stop, kShares,
               "when an iteration lowers the residual by less than this part of it; 0: never");
  group.number("--noise-level", settings.noise, kShares,
               "stop at a residual of this, the projections' own noise; 0: never");
}

void add_method(CLI::App& app, ReconstructOptions& options) {
  OptionGroup group(app, "Method");
  group.number("--method", options.method, CLI::IsMember({"fdk", "sart", "os-sart", "sirt"}),
               "fdk, sart, os-sart or sirt");
  group.number("--step", options.filtered.step, kSteps, "of the rays, voxels");
}

void add_slices(CLI::App& app, SliceOptions& slices, const std::string& what) {
  OptionGroup group(app, "Output");
  app.add_option("--slices", slices.name, "pictures of " + what + ": NAME_x.png, NAME_y.png, NAME_z.png")
      ->type_name("NAME")
      ->group("Output");
  group.parsed("--grey", "LOW,HIGH", "values that are black and white (nearly the least and the greatest)",
               [&slices](const std::string& name, const std::string& text) {
                 const std::vector<double> range = parse_numbers(name, text, 2);
                 if (range[0] >= range[1]) throw expected(name, "LOW below HIGH", text);
                 slices.grey = {range[0], range[1]};
               });
  group
      .parsed("--slice", "AXIS=INDEX", "a plane in place of the three in the middle, as z=75; repeatable",
              [&slices](const std::string& name, const std::string& text) {
                static const std::regex kPlane("([xyz])=([0-9]{1,5})");
                std::smatch parts;
                if (!std::regex_match(text, parts, kPlane)) throw expected(name, "x, y or z = a whole number", text);
                slices.planes.emplace_back(text[0] - 'x', std::stoi(parts[2]));
              })
      ->take_all();
}

void check_volume_name(const char* option, const std::filesystem::path& path) {
  if (path.empty() || is_volume_output(path)) return;
  throw UsageError(fmt::format("{}: expected a name that ends in .nrrd, .mhd, .mha, .nii or .nii.gz, got {}", option,
                               in_quotes(path.string())));
}

void check_stack_name(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  for (const char* known : {".nrrd", ".mhd", ".mha", ".raw", ".pfm", ".tif", ".tiff"}) {
    if (extension == known) return;
  }
  throw UsageError("--output: expected a name that ends in .nrrd, .mhd, .mha, .raw, .pfm or .tif, got " +
                   in_quotes(path.string()));
}

void add_projecting(CLI::App& app, ProjectOptions& options) {
  add_object(app, options.object, "OBJECT", "what is projected");
  add_own_scan(app, options.scan);
  add_volume(app, options.scan);
  OptionGroup group(app, "Projections"), output(app, "Output");
  group.flag("--by-board", options.by_board, "of a phantom's voxels by the board, not by its closed form");
  group.number("--step", options.step, kSteps, "of the board's rays, voxels");
  group.number("--photons", options.photons, CLI::Range(0.0, 1e15),
               "a pixel would count without an object: Poisson noise by --seed; 0: none");
  output
      .file("-o,--output", options.output,
            "the views: .nrrd .mhd .mha .raw, or a file each: .tif .pfm (with plastimatch's matrices). Beside them "
            "NAME.textproto, the SCAN for reconstruct")
      ->required();
  output.file("--voxels", options.voxels, "also write a phantom's voxels: .nrrd .mhd .mha .nii");
  add_board_options(app, options.board);
}

void add_reconstructing(CLI::App& app, ReconstructOptions& options) {
  add_input(app, options.scan);
  add_volume(app, options.scan);
  add_method(app, options);
  add_fdk(app, options.filtered);
  add_algebraic(app, options.algebraic);
  OptionGroup(app, "Output")
      .file("-o,--output", options.output, "the volume: .nrrd .mhd .mha .nii .nii.gz, with spacing and origin")
      ->required();
  add_slices(app, options.slices, "it");
  add_plan_options(app, options.plan, "the volume");
  add_board_options(app, options.board);
}

void check_reconstruction(const CLI::App& app, ReconstructOptions& options) {
  AlgebraicSettings& algebraic = options.algebraic;
  algebraic.method = options.method == "sirt"      ? Method::kSirt
                     : options.method == "os-sart" ? Method::kOsSart
                                                   : Method::kSart;
  algebraic.step = options.filtered.step;
  algebraic.seed = options.board.seed;
  check_plan(options.plan);
  check_volume_name("--output", options.output);
  if (!options.plan.wanted()) return;
  if (!options.fdk()) {
    throw UsageError("--method: expected fdk with --max-error and --time-budget, got " + options.method);
  }
  for (const char* chosen : {"--rays", "--step", "--normalise"}) refuse_with_plan(app, chosen);
}

void add_comparing(CLI::App& app, CompareOptions& options) {
  app.add_option("VOLUME", options.volume, "a volume file")->required();
  add_object(app, options.truth, "TRUTH", "what it should be");
  const char* field = "Field of view";
  app.add_option("--field-radius", options.field.radius, "voxels further from the axis are left out")
      ->check(CLI::PositiveNumber)
      ->group(field);
  app.add_option("--field-height", options.field.half_height, "and those further from the middle plane")
      ->check(CLI::PositiveNumber)
      ->group(field);
  OptionGroup output(app, "Output");
  output.file("--difference", options.difference, "the values less what they should be, as a volume");
  output.file("--profiles", options.profiles, "values and truth along the three lines through the middle, CSV");
  output.file("--stats", options.stats, "the figures as JSON");
  add_slices(app, options.slices, "the difference");
}

void add_importing(CLI::App& app, ImportOptions& options) {
  add_input(app, options.scan);
  add_volume(app, options.scan);
  OptionGroup(app, "Output").file("-o,--output", options.output, "a scan file (printed)");
}

void add_charts(CLI::App& app, ChartOptions& options) {
  app.add_option("DIR", options.folder, "where the tables go: cone_beam_NAME.csv, which script/charts draws");
  app.add_option("--only", options.only, "this chart; repeatable (all)")->type_name("NAME");
  app.add_option("--point", options.point, "print this row of a table, and write nothing")->type_name("NAME");
  add_board_options(app, options.board);
}

}  // namespace

std::optional<ConeBeamOptions> parse_cone_beam_options(int argc, const char* const* argv, std::ostream& out) {
  ProjectOptions project;
  ReconstructOptions reconstruct;
  CompareOptions compare;
  ImportOptions import;
  ChartOptions charts;
  CLI::App app("Cone-beam tomography by a GI-Cube board.", "gicube-cone-beam");
  app.footer(kFooter);
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.require_subcommand(1);
  CLI::App* const projecting = app.add_subcommand("project", "projections of a phantom or a volume");
  CLI::App* const reconstructing = app.add_subcommand("reconstruct", "a volume from the projections of a scan");
  CLI::App* const comparing = app.add_subcommand("compare", "a volume with what it should be");
  CLI::App* const importing = app.add_subcommand("import", "a scan as a scan file, to be looked at and edited");
  CLI::App* const charting = app.add_subcommand("charts", "tables of errors against costs, where the methods fail");
  add_projecting(*projecting, project);
  add_reconstructing(*reconstructing, reconstruct);
  add_comparing(*comparing, compare);
  add_importing(*importing, import);
  add_charts(*charting, charts);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  if (projecting->parsed()) {
    check_stack_name(project.output);
    check_volume_name("--voxels", project.voxels);
    return project;
  }
  if (reconstructing->parsed()) {
    check_reconstruction(*reconstructing, reconstruct);
    return reconstruct;
  }
  if (importing->parsed()) return import;
  if (charting->parsed()) {
    if (charts.folder.empty() == charts.point.empty()) throw UsageError("charts: expected one of DIR and --point");
    return charts;
  }
  check_volume_name("--difference", compare.difference);
  return compare;
}

ScanDescription description_of(const ScanOptions& options) {
  StackFiles projections{options.projections, {}};
  if (options.type) {
    if (options.projections.empty()) throw UsageError("--type: only with --projections");
    projections.raw = RawLayout{};
    projections.raw->type = *options.type;
  }
  ScanDescription out;
  if (!options.input.empty()) {
    out = read_description(options.input, projections);
  } else {
    ConeGeometry& geometry = out.geometry;
    geometry.source_to_axis = options.source_to_axis;
    geometry.source_to_detector = options.source_to_detector;
    geometry.detector = {options.detector_size[0], options.detector_size[1], options.pitch, options.pitch};
    const double radians = std::numbers::pi / 180;
    geometry.angles = even_angles(options.views, 0, options.arc * radians);
  }
  if (options.size) out.geometry.volume.dims = *options.size;
  if (options.spacing) out.geometry.volume.spacing = *options.spacing;
  complete_volume(out);
  return out;
}

}  // namespace gicube::samples
