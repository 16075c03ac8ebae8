// Parts of scene.proto that stand in several places: vectors, colours, volumes, transfer functions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "gicube/v1/scene.pb.h"
#include "scene/formats/volume_file.h"
#include "scene/graph/faults.h"
#include "scene/transfer_function_file.h"

namespace gicube::samples {

// Each reports what is wrong as a fault of `field`.
Vec3 finite_vector(Faults& faults, const std::string& field, const v1::Vector& v);
// 0..1 each.
Colour read_colour(Faults& faults, const std::string& field, const v1::Colour& colour);
VolumeSource read_volume_source(Faults& faults, const std::string& field, const v1::VolumeSource& source,
                                const std::filesystem::path& folder);
// Nothing if there is a fault.
std::optional<TransferFunctionFile> read_transfer_function_of(Faults& faults, const std::string& field,
                                                              const v1::TransferFunction& source,
                                                              const std::filesystem::path& folder);

}  // namespace gicube::samples
