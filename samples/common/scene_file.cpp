#include "common/scene_file.h"

#include <fmt/format.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "common/buckyball.h"
#include "common/input_error.h"
#include "gicube/v1/scene.pb.h"

namespace gicube::samples {
namespace {

constexpr std::uintmax_t kMaxSceneBytes = 1 << 20;  // chosen: far above any scene
constexpr int kMaxCutPlanes = 6;                    // as View
constexpr double kMaxImageSize = 4095;              // as View

std::string shown(double value) { return fmt::format("{}", value); }

// Faults of the text and of its meaning, in the order in which they are met.
class Faults : public google::protobuf::io::ErrorCollector {
 public:
  explicit Faults(std::string name) : name_(std::move(name)) {}

  void AddError(int line, int column, const std::string& message) override {
    add(fmt::format(":{}:{}: {}", line + 1, column + 1, message));
  }
  // The parser only warns of unknown fields when it is told to go on behind them.
  void AddWarning(int line, int column, const std::string& message) override { AddError(line, column, message); }

  void fault(const std::string& field, const std::string& expected, const std::string& got) {
    add(fmt::format(": {}: expected {}, got {}", field, expected, got));
  }
  void check(bool good, const std::string& field, const std::string& expected, const std::string& got) {
    if (!good) fault(field, expected, got);
  }
  // Runs something that throws InputError or FileError about its own file.
  template <typename Call>
  void gather(const std::string& field, const Call& call) {
    try {
      call();
    } catch (const std::runtime_error& error) {
      add(fmt::format(": {}: {}", field, error.what()));
    }
  }
  void throw_if_any() const {
    if (!text_.empty()) throw InputError(text_);
  }

 private:
  void add(const std::string& text) { text_ += fmt::format("{}{}{}", text_.empty() ? "" : "\n", name_, text); }

  std::string name_;
  std::string text_;
};

// Turns the parsed message into a Scene; a fault leaves that part of the Scene at its default.
class Translator {
 public:
  Translator(Faults& faults, std::filesystem::path folder) : faults_(faults), folder_(std::move(folder)) {}

  Scene translate(const v1::Scene& source) {
    Scene scene;
    if (source.has_volume()) {
      scene.volume = volume(source.volume());
    } else {
      faults_.fault("volume", "a volume", "none");
    }
    if (source.has_transfer_function()) transfer_function(source.transfer_function(), scene);
    if (source.has_phong()) scene.phong = phong(source.phong());
    if (source.has_light()) scene.light = light(source.light());
    scene.camera = camera(source.camera());
    for (int i = 0; i < source.cut_plane_size(); ++i) cut_plane(i, source.cut_plane(i), scene.view);
    faults_.check(source.cut_plane_size() <= kMaxCutPlanes, "cut_plane", "at most 6",
                  std::to_string(source.cut_plane_size()));
    image(source.image(), scene.view);
    scene.view.step = number("step", source.step(), 1.0 / 64, 16);
    scene.view.opacity_threshold = number("opacity_threshold", source.opacity_threshold(), 0, 1);
    scene.view.shade = source.shade();
    scene.view.jitter = source.jitter();
    return scene;
  }

 private:
  double number(const std::string& field, double value, double low, double high) {
    faults_.check(value >= low && value <= high, field, shown(low) + " to " + shown(high), shown(value));
    return value;
  }

  Vec3 vector(const std::string& field, const v1::Vector& v) {
    faults_.check(std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z()), field, "finite numbers",
                  fmt::format("{} {} {}", v.x(), v.y(), v.z()));
    return {v.x(), v.y(), v.z()};
  }

  VolumeSource volume(const v1::VolumeSource& source) {
    VolumeSource result;
    if (source.has_builtin() == source.has_file()) {
      faults_.fault("volume", "either builtin or file", source.has_file() ? "both" : "neither");
    }
    if (source.has_builtin()) {
      faults_.check(source.builtin() == "buckyball", "volume.builtin", "\"buckyball\"", in_quotes(source.builtin()));
      result.builtin = source.builtin();
    }
    if (source.has_file()) result.file = folder_ / source.file();
    if (source.has_size()) {
      faults_.check(source.has_builtin(), "volume.size", "only with builtin", "it with a file");
      number("volume.size", source.size(), kMinBuckyballSize, kMaxBuckyballSize);
    }
    result.size = static_cast<int>(source.size());
    if (source.spacing_size() != 0) {
      const bool good = source.spacing_size() == 3;
      faults_.check(good, "volume.spacing", "3 numbers, x y z", std::to_string(source.spacing_size()));
      for (const double edge : source.spacing()) {
        faults_.check(edge > 0 && std::isfinite(edge), "volume.spacing", "numbers above 0", shown(edge));
      }
      if (good) result.spacing = Vec3{source.spacing(0), source.spacing(1), source.spacing(2)};
    }
    if (source.has_raw()) {
      faults_.check(source.has_file(), "volume.raw", "only with file", "it without");
      result.raw = raw(source.raw());
      if (result.spacing) result.raw->spacing = *result.spacing;
    }
    return result;
  }

  RawLayout raw(const v1::RawLayout& source) {
    RawLayout layout;
    faults_.check(source.dims_size() == 3, "volume.raw.dims", "3 numbers, x y z", std::to_string(source.dims_size()));
    for (int i = 0; i < std::min(source.dims_size(), 3); ++i) {
      layout.dims[static_cast<std::size_t>(i)] =
          static_cast<int>(number("volume.raw.dims", source.dims(i), 1, kMaxFileDim));
    }
    faults_.gather("volume.raw", [&] { layout.type = sample_type_named(source.type(), "type"); });
    layout.big_endian = source.big_endian();
    layout.skip_bytes = source.skip_bytes();
    return layout;
  }

  void transfer_function(const v1::TransferFunction& source, Scene& scene) {
    const bool points = source.colour_size() != 0 || source.opacity_size() != 0;
    const int ways = int(source.has_file()) + int(source.has_preset()) + int(points);
    if (ways != 1) {
      faults_.fault("transfer_function", "one of file, preset or points", ways == 0 ? "none" : "several");
    } else if (source.has_file()) {
      faults_.gather("transfer_function.file",
                     [&] { scene.transfer_function = read_transfer_function(folder_ / source.file()); });
    } else if (source.has_preset()) {
      faults_.gather("transfer_function", [&] { scene.transfer_function = find_preset(source.preset()); });
    } else {
      faults_.gather("transfer_function",
                     [&] { scene.transfer_function = parse_transfer_function(as_text(source), "points"); });
    }
  }

  // The points as a transfer function file, so that one parser checks both.
  static std::string as_text(const v1::TransferFunction& source) {
    const auto word = [](bool there, double value) { return there ? shown(value) : "missing"; };
    std::string text;
    for (const v1::ColourPoint& point : source.colour()) {
      const v1::Colour& colour = point.colour();
      text += fmt::format("colour {} {} {} {}\n", word(point.has_value(), point.value()), colour.red(), colour.green(),
                          colour.blue());
    }
    for (const v1::OpacityPoint& point : source.opacity()) {
      text += fmt::format("opacity {} {}\n", word(point.has_value(), point.value()),
                          word(point.has_opacity(), point.opacity()));
    }
    return text;
  }

  Phong phong(const v1::Phong& source) {
    Phong result;
    result.ambient = number("phong.ambient", source.ambient(), 0, 1.99);
    result.diffuse = number("phong.diffuse", source.diffuse(), 0, 1.99);
    result.specular = number("phong.specular", source.specular(), 0, 1.99);
    result.shininess = number("phong.shininess", source.shininess(), 1, 1000);
    return result;
  }

  Vec3 light(const v1::DirectionalLight& source) {
    const Vec3 towards = vector("light.towards", source.towards());
    faults_.check(length(towards) > 0, "light.towards", "a direction", "0 0 0");
    return towards;
  }

  CameraSettings camera(const v1::Camera& source) {
    CameraSettings result;
    if (source.has_eye()) result.eye = vector("camera.eye", source.eye());
    if (source.has_look_at()) result.look_at = vector("camera.look_at", source.look_at());
    if (source.has_up()) {
      result.up = vector("camera.up", source.up());
      faults_.check(length(*result.up) > 0, "camera.up", "a direction", "0 0 0");
    }
    if (result.eye && result.look_at) {
      faults_.check(!(*result.eye == *result.look_at), "camera.look_at", "another point than camera.eye", "the same");
    }
    if (source.has_fov_degrees()) {
      result.fov_degrees = source.fov_degrees();
      faults_.check(source.fov_degrees() > 0 && source.fov_degrees() < 180, "camera.fov_degrees",
                    "more than 0 and less than 180", shown(source.fov_degrees()));
    }
    if (source.has_orthographic_height()) {
      result.orthographic_height = source.orthographic_height();
      faults_.check(source.orthographic_height() > 0 && std::isfinite(source.orthographic_height()),
                    "camera.orthographic_height", "a number above 0", shown(source.orthographic_height()));
      faults_.check(!source.has_fov_degrees(), "camera", "fov_degrees or orthographic_height", "both");
    }
    return result;
  }

  void cut_plane(int index, const v1::CutPlane& source, View& view) {
    const std::string field = fmt::format("cut_plane[{}]", index);
    const Vec3 normal = vector(field + ".normal", source.normal());
    faults_.check(length(normal) > 0, field + ".normal", "a direction", "0 0 0");
    faults_.check(std::isfinite(source.offset()), field + ".offset", "a finite number", shown(source.offset()));
    view.cut_planes.push_back({normal, source.offset()});
  }

  void image(const v1::ImageSettings& source, View& view) {
    view.width = static_cast<int>(number("image.width", source.width(), 1, kMaxImageSize));
    view.height = static_cast<int>(number("image.height", source.height(), 1, kMaxImageSize));
    const std::uint32_t samples = source.samples_per_axis();
    faults_.check(samples == 1 || samples == 2 || samples == 4, "image.samples_per_axis", "1, 2 or 4",
                  std::to_string(samples));
    view.samples_per_axis = static_cast<int>(samples);
  }

  Faults& faults_;
  std::filesystem::path folder_;
};

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder) {
  Faults faults(name);
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&faults);
  parser.AllowUnknownField(true);  // reported by AddWarning, and the parser goes on to the next fault
  v1::Scene message;
  if (!parser.ParseFromString(text, &message)) faults.throw_if_any();
  Scene scene = Translator(faults, folder).translate(message);
  faults.throw_if_any();
  return scene;
}

Scene read_scene(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path.string(), "a scene file", "no such file");
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (bytes > kMaxSceneBytes) {
    throw InputError(path.string(), "a scene file of at most 1 MiB", std::to_string(bytes) + " bytes");
  }
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError(path.string(), "a scene file", "one that can't be read");
  return parse_scene(text.str(), path.string(), path.parent_path());
}

bool is_scene_path(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".scene" || extension == ".textproto" || extension == ".pbtxt" || extension == ".txt";
}

}  // namespace gicube::samples
