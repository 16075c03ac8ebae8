#include <algorithm>
#include <cmath>

#include "scene/graph/graph_reader.h"

namespace gicube::scene {
namespace {

constexpr int kMaxReadDepth = 60;  // of nodes within nodes; below the limits of the text parser and of build()

struct Reader {
  const NamedFiles& files;
  Faults& faults;

  Node node(const v1::Node& source, const std::string& place, int depth) const {
    Node result;
    result.name = source.name();
    const std::string field = result.name.empty() ? place : "node[" + result.name + "]";
    result.material = source.material();
    for (int i = 0; i < source.transform_size(); ++i) {
      result.transforms.push_back(
          read_transform(faults, fmt::format("{}.transform[{}]", field, i), source.transform(i)));
    }
    std::vector<const google::protobuf::FieldDescriptor*> fields;
    source.GetReflection()->ListFields(source, &fields);
    const auto contents =
        std::ranges::count_if(fields, [](const auto* each) { return each->number() >= v1::Node::kChildFieldNumber; });
    faults.check(contents == 1, field, "children, one shape, one hypertexture or one volume",
                 contents == 0 ? "nothing" : "several");
    result.content = content(source, field);
    if (depth >= kMaxReadDepth) {
      faults.check(source.child_size() == 0, field, fmt::format("at most {} levels", kMaxReadDepth), "more");
      return result;
    }
    for (int i = 0; i < source.child_size(); ++i) {
      result.children.push_back(node(source.child(i), fmt::format("{}.child[{}]", field, i), depth + 1));
    }
    return result;
  }

  Content content(const v1::Node& source, const std::string& field) const {
    if (source.has_volume()) {
      const std::string place = field + ".volume";
      faults.check(!source.volume().has_builtin(), place, "a file", "a builtin");
      return ScanContent{read_volume_source(faults, place, source.volume(), files)};
    }
    if (source.has_hypertexture()) return hypertexture(source.hypertexture(), field + ".hypertexture");
    std::optional<Shape> shape = shape_of(source, field);
    if (!shape) return Group{};
    return *shape;
  }

  Content hypertexture(const v1::Hypertexture& source, const std::string& field) const {
    Hypertexture result;
    faults.check_one(field, "one shape",
                     {source.has_sphere(), source.has_box(), source.has_torus(), source.has_cylinder(),
                      source.has_mesh(), source.has_builtin()});
    if (auto shape = shape_of(source, field)) result.shape = *shape;
    faults.gather_part(field, [&] { result.kind = hypertexture_named(source.kind()); });
    result.softness = source.softness();
    result.frequency = source.frequency();
    result.octaves = static_cast<int>(std::min(source.octaves(), 1000u));
    result.amplitude = source.amplitude();
    result.time = source.time();
    result.length = source.length();
    result.curl = source.curl();
    result.stretch = source.stretch();
    result.seed = source.seed();
    faults.gather_part(field, [&] { check(result); });
    return result;
  }

  // The shape of a node or a hypertexture; nothing if it has none.
  template <typename Source>
  std::optional<Shape> shape_of(const Source& source, const std::string& field) const {
    std::optional<Shape> shape;
    std::string kind;
    if (source.has_sphere()) kind = ".sphere", shape = SphereShape{source.sphere().radius()};
    if (source.has_box()) {
      const v1::Box& box = source.box();
      BoxShape own{.rounding = box.rounding()};
      if (box.has_low()) own.low = finite_vector(faults, field + ".box.low", box.low());
      if (box.has_high()) own.high = finite_vector(faults, field + ".box.high", box.high());
      kind = ".box", shape = own;
    }
    if (source.has_torus()) kind = ".torus", shape = TorusShape{source.torus().radius(), source.torus().tube()};
    if (source.has_cylinder()) {
      const v1::Cylinder& cylinder = source.cylinder();
      kind = ".cylinder";
      shape = CylinderShape{cylinder.radius(), cylinder.height(), cylinder.inner_radius(), cylinder.rounding()};
    }
    if (source.has_mesh()) {
      const std::string& name = source.mesh().file();
      kind = ".mesh", shape = MeshShape{name.empty() ? "" : named_file(faults, field + kind, name, files), nullptr};
      if (!name.empty() && std::get<MeshShape>(*shape).file.empty()) return std::nullopt;
    }
    if (source.has_builtin()) kind = "", shape = BuiltinShape{source.builtin()};
    if (shape) faults.gather_part(field + kind, [&] { check(*shape); });
    return shape;
  }
};

}  // namespace

Transform read_transform(Faults& faults, const std::string& field, const v1::Transform& source) {
  faults.check_one(field, "one of translate, rotate and scale",
                   {source.has_translate(), source.has_rotate(), source.has_scale()});
  Transform result = Translate{};
  if (source.has_translate()) result = Translate{finite_vector(faults, field + ".translate", source.translate())};
  if (source.has_rotate()) {
    Rotate rotate;
    if (source.rotate().has_axis()) rotate.axis = finite_vector(faults, field + ".rotate.axis", source.rotate().axis());
    rotate.degrees = source.rotate().degrees();
    result = rotate;
  }
  if (source.has_scale()) {
    const v1::Scaling& scale = source.scale();
    faults.check(!scale.has_all() || !(scale.has_x() || scale.has_y() || scale.has_z()), field + ".scale",
                 "all, or x, y and z", "both");
    result =
        scale.has_all() ? Scale{{scale.all(), scale.all(), scale.all()}} : Scale{{scale.x(), scale.y(), scale.z()}};
  }
  faults.gather_part(field, [&] { map_of({result}); });
  return result;
}

World read_world(const v1::World& source, const NamedFiles& files, Faults& faults) {
  World world;
  if (source.has_low()) world.low = finite_vector(faults, "world.low", source.low());
  if (source.has_high()) world.high = finite_vector(faults, "world.high", source.high());
  world.size = static_cast<int>(std::min(source.size(), 1'000'000u));
  world.densities = source.partial_volumes() ? Densities::kPartialVolumes : Densities::kRamp;
  faults.check(source.node_size() > 0, "world.node", "at least one", "none");
  const Reader reader{files, faults};
  for (int i = 0; i < source.node_size(); ++i) {
    world.root.children.push_back(reader.node(source.node(i), fmt::format("world.node[{}]", i), 1));
  }
  faults.gather([&] { grid_of(world); });
  return world;
}

}  // namespace gicube::scene
