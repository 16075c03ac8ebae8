// The board's look-up tables: their wanted contents, the contents last sent, and the sending of differences.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "device.h"
#include "encode/volume/gradients.h"
#include "gicube/illumination.h"
#include "gicube/material.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/volume.h"
#include "gicube/wire/lut.h"
#include "gicube/wire/voxel.h"

namespace gicube {

// The source of a sample's brightness: the reflectance map, or irradiance words of the light that a sample absorbed or
// that falls on it.
enum class SampleLight { kMap, kAbsorbed, kIncident };

// Arguments must have passed their checks. Only changes are sent.
class Tables {
 public:
  explicit Tables(Device& device) : device_(device) {}

  void set_wide(bool wide) { wide_ = wide; }
  void set_irradiance_words(int words) { irradiance_words_ = words; }

  void set_codebook(GradientCodebook codebook) {
    codebook_ = std::move(codebook);
    gradients_sent_ = false;
  }
  // The codebook in force. The default one is made on first use.
  const GradientCodebook& codebook() {
    if (!codebook_) codebook_.emplace();
    return *codebook_;
  }
  void send_gradients();

  void set_function(const TransferFunction& function, int tag) {
    functions_[static_cast<std::size_t>(tag)] = function;
    ++changes_;
  }
  std::vector<TransferFunction> functions() const {  // of all tags that have one
    std::vector<TransferFunction> out;
    for (const auto& function : functions_) {
      if (function) out.push_back(*function);
    }
    return out;
  }
  void set_shading(const Shading& shading) {
    shading_ = shading;
    ++changes_;
  }
  void set_material(const Material& material, int tag);
  const std::array<Material, wire::kTags>& materials() const { return materials_; }
  // With irradiance, entries hold gains instead of shading coefficients, and the reflectance map holds highlights only
  // (lut.h).
  void set_light(SampleLight light) { light_ = light; }

  // The segmentation LUT depends on the volume by its map from values to densities.
  void send_segmentation(ValueRange range);
  std::span<const wire::SegmentationEntry> segmentation() const { return segmentation_; }
  // Media whose lighting rays, `step` voxels between samples, leave their light with an error of more than about 1%.
  std::vector<std::string> light_warnings(Albedo albedo, EnergyRules rules, double step) const;

  void send_reflectance(Vec3 towards_eye);

  // One flag per block. To be called after the board has cleared its flags: forget_flags().
  void send_flags(std::span<const std::uint8_t> flags);
  void forget_flags() { flags_.clear(); }
  // For a new board: forgets what was sent, and sends the materials again.
  void restore();
  // Lists everything but the device. Throws CheckpointFault.
  void state(Archive& archive);

 private:
  Device& device_;
  bool wide_ = false;
  int irradiance_words_ = 1;
  std::optional<GradientCodebook> codebook_;
  bool gradients_sent_ = false;
  std::array<std::optional<TransferFunction>, wire::kTags> functions_;
  std::vector<wire::SegmentationEntry> segmentation_ =
      std::vector<wire::SegmentationEntry>(wire::kSegmentationEntries);  // a tag never set is invisible
  Shading shading_;
  std::array<Material, wire::kTags> materials_;
  SampleLight light_ = SampleLight::kMap;
  // The inputs of the current tables: building tables takes longer than sending a small batch of rays.
  struct Source {
    std::uint64_t changes = 0;
    SampleLight light = SampleLight::kMap;
    ValueRange range{};
    Vec3 towards_eye;
    void state(Archive::Record& record);
    friend constexpr bool operator==(const Source&, const Source&) = default;
  };
  std::uint64_t changes_ = 1;  // of functions, shading and materials
  Source segmentation_source_, reflectance_source_;
  std::vector<std::uint8_t> reflectance_;  // as last sent; empty = never
  std::vector<std::uint8_t> flags_;        // packed, as last sent; empty = all clear
};

}  // namespace gicube
