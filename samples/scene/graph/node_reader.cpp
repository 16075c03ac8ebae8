#include <algorithm>
#include <cmath>

#include "scene/graph/graph_reader.h"

namespace gicube::samples {
namespace {

constexpr int kMaxReadDepth = 60;  // of nodes within nodes; below the limits of the text parser and of build()

bool has_shape(const v1::Node& source) {
  return source.has_sphere() || source.has_box() || source.has_torus() || source.has_cylinder() || source.has_mesh() ||
         source.has_builtin();
}

int contents_of(const v1::Node& source) {
  return int(source.has_sphere()) + int(source.has_box()) + int(source.has_torus()) + int(source.has_cylinder()) +
         int(source.has_mesh()) + int(source.has_builtin()) + int(source.has_volume());
}

}  // namespace

World GraphReader::world(const v1::World& source) {
  World world;
  if (source.has_low()) world.low = finite_vector(faults_, "world.low", source.low());
  if (source.has_high()) world.high = finite_vector(faults_, "world.high", source.high());
  world.size = static_cast<int>(std::min(source.size(), 1'000'000u));
  faults_.check(source.node_size() > 0, "world.node", "at least one", "none");
  for (int i = 0; i < source.node_size(); ++i) {
    world.root.children.push_back(node(source.node(i), fmt::format("world.node[{}]", i), 1));
  }
  faults_.gather("world", [&] { grid_of(world); });
  return world;
}

Node GraphReader::node(const v1::Node& source, const std::string& place, int depth) {
  Node result;
  result.name = source.name();
  const std::string field = result.name.empty() ? place : "node[" + result.name + "]";
  result.material = source.material();
  for (int i = 0; i < source.transform_size(); ++i) {
    result.transforms.push_back(transform(source.transform(i), fmt::format("{}.transform[{}]", field, i)));
  }
  const int contents = contents_of(source) + (source.child_size() > 0 ? 1 : 0);
  faults_.check(contents == 1, field, "children, one shape or one volume", contents == 0 ? "nothing" : "several");
  result.content = content(source, field);
  if (depth >= kMaxReadDepth) {
    faults_.check(source.child_size() == 0, field, fmt::format("at most {} levels", kMaxReadDepth), "more");
    return result;
  }
  for (int i = 0; i < source.child_size(); ++i) {
    result.children.push_back(node(source.child(i), fmt::format("{}.child[{}]", field, i), depth + 1));
  }
  return result;
}

Transform GraphReader::transform(const v1::Transform& source, const std::string& field) {
  const int kinds = int(source.has_translate()) + int(source.has_rotate()) + int(source.has_scale());
  faults_.check(kinds == 1, field, "one of translate, rotate and scale", kinds == 0 ? "none" : "several");
  Transform result = Translate{};
  if (source.has_translate()) result = Translate{finite_vector(faults_, field + ".translate", source.translate())};
  if (source.has_rotate()) {
    Rotate rotate;
    if (source.rotate().has_axis()) {
      rotate.axis = finite_vector(faults_, field + ".rotate.axis", source.rotate().axis());
    }
    rotate.degrees = source.rotate().degrees();
    result = rotate;
  }
  if (source.has_scale()) {
    const v1::Scaling& scale = source.scale();
    faults_.check(!scale.has_all() || !(scale.has_x() || scale.has_y() || scale.has_z()), field + ".scale",
                  "all, or x, y and z", "both");
    result =
        scale.has_all() ? Scale{{scale.all(), scale.all(), scale.all()}} : Scale{{scale.x(), scale.y(), scale.z()}};
  }
  faults_.gather_part(field, [&] { map_of({result}); });
  return result;
}

Shape GraphReader::box(const v1::Box& source, const std::string& field) {
  BoxShape box;
  if (source.has_low()) box.low = finite_vector(faults_, field + ".box.low", source.low());
  if (source.has_high()) box.high = finite_vector(faults_, field + ".box.high", source.high());
  box.rounding = source.rounding();
  return box;
}

Content GraphReader::content(const v1::Node& source, const std::string& field) {
  if (source.has_volume()) {
    const std::string place = field + ".volume";
    faults_.check(!source.volume().has_builtin(), place, "a file", "a builtin");
    return ScanContent{read_volume_source(faults_, place, source.volume(), folder_)};
  }
  if (!has_shape(source)) return Group{};
  Shape shape;
  std::string kind;
  if (source.has_sphere()) kind = ".sphere", shape = SphereShape{source.sphere().radius()};
  if (source.has_box()) kind = ".box", shape = box(source.box(), field);
  if (source.has_torus()) kind = ".torus", shape = TorusShape{source.torus().radius(), source.torus().tube()};
  if (source.has_cylinder()) {
    const v1::Cylinder& cylinder = source.cylinder();
    kind = ".cylinder";
    shape = CylinderShape{cylinder.radius(), cylinder.height(), cylinder.inner_radius(), cylinder.rounding()};
  }
  if (source.has_mesh()) {
    kind = ".mesh";
    MeshShape mesh;
    if (!source.mesh().file().empty()) mesh.file = folder_ / source.mesh().file();
    shape = mesh;
  }
  if (source.has_builtin()) shape = BuiltinShape{source.builtin()};
  faults_.gather_part(field + kind, [&] { check(shape); });
  return shape;
}

}  // namespace gicube::samples
