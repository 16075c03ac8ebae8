// Conversion of a parsed scene file to the structs of the scenegraph. A faulty part of the scene keeps its defaults.
#pragma once

#include "gicube/scene/scene.h"
#include "gicube/v1/scene.pb.h"
#include "scene/common/faults.h"
#include "scene/common/named_files.h"

namespace gicube::scene {

// Reads world, materials, lights, illumination and engines. `files`: those that the text names.
void read_graph(const v1::Scene& source, const NamedFiles& files, Faults& faults, Scene& scene);

World read_world(const v1::World& source, const NamedFiles& files, Faults& faults);

// Parts that occur in several messages. Their faults are those of `field`.
Vec3 finite_vector(Faults& faults, const std::string& field, const v1::Vector& v);
// A file that `field` of the text names. Empty: there is a fault.
std::filesystem::path named_file(Faults& faults, const std::string& field, const std::string& name,
                                 const NamedFiles& files);
// Components 0..1.
Colour read_colour(Faults& faults, const std::string& field, const v1::Colour& colour);
VolumeSource read_volume_source(Faults& faults, const std::string& field, const v1::VolumeSource& source,
                                const NamedFiles& files);
// A vector of any length but 0.
Vec3 read_direction(Faults& faults, const std::string& field, const v1::Vector& source);
Transform read_transform(Faults& faults, const std::string& field, const v1::Transform& source);
CameraSettings read_camera(Faults& faults, const std::string& field, const v1::Camera& source);
Phong read_phong(Faults& faults, const v1::Phong& source);
void read_image(Faults& faults, const v1::ImageSettings& source, View& view);
// Nothing if there is a fault.
std::optional<TransferFunctionFile> read_transfer_function_of(Faults& faults, const std::string& field,
                                                              const v1::TransferFunction& source,
                                                              const NamedFiles& files);

}  // namespace gicube::scene
