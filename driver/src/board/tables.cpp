#include "tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "board/saved/saved_records.h"
#include "encode/lights.h"
#include "encode/look_up_tables.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/wire/memory_map.h"

namespace gicube {
namespace {

constexpr int kThinMedium = 50;            // units of an opacity's word; half a unit is 1% of it
constexpr double kTooDeep = 0.01;          // chosen; free paths
constexpr double kDeepPerDepth = 1. / 12;  // times the square of a step's depth: how much too deep deposits lie

bool is_phase_function(const Material& material) {
  return material.bsdf == Bsdf::kIsotropic ||
         (material.bsdf == Bsdf::kTrap &&
          (material.routine == kHenyeyGreensteinRoutine || material.routine == kTabulatedRoutine));
}

}  // namespace

std::vector<std::string> Tables::light_warnings(Albedo albedo, EnergyRules rules, double step) const {
  constexpr double kOne = wire::kClassifiedOpacityOne;
  const std::size_t entries = segmentation_.size() / wire::kTags;
  std::vector<std::string> out;
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    int most = 0, most_clear = 0;  // `most_clear`: without full scale
    for (const wire::SegmentationEntry& entry : std::span(segmentation_).subspan(tag * entries, entries)) {
      most = std::max<int>(most, entry.opacity);
      if (entry.opacity < wire::kClassifiedOpacityOne) most_clear = std::max<int>(most_clear, entry.opacity);
    }
    if (most > 0 && most < kThinMedium) {
      // Lighting rays use the whole units of a table's opacities, also on the wide datapath.
      out.push_back(
          fmt::format("tag {} has opacities of at most {:.2g}, which are rounded to 1/{}: the light that it absorbs is "
                      "off by up to {:.2g}%",
                      tag, most / kOne, kOne, 50.0 / most));
    }
    const double depth = -std::log1p(-most_clear / kOne) * step, deep = depth * depth * kDeepPerDepth;
    const bool weighted = albedo == Albedo::kLow && rules == EnergyRules::kConserving;
    if (weighted && materials_[tag].scattering > 0 && is_phase_function(materials_[tag]) && deep > kTooDeep) {
      out.push_back(fmt::format(
          "tag {} has steps of up to {:.2g} free paths: low albedo leaves light up to {:.2g} free paths too "
          "deep; use shorter steps or high albedo",
          tag, depth, deep));
    }
  }
  return out;
}

void Tables::send_gradients() {
  if (gradients_sent_) return;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(wire::kGradientLut.bytes));
  std::size_t at = 0;
  for (const wire::GradientEntry& entry : codebook().entries()) {
    wire::store(std::span(bytes), at, wire::to_word(entry));
    at += wire::kGradientEntryBytes;
  }
  device_.write_memory(wire::kGradientLut.base, bytes);
  gradients_sent_ = true;
}

void Tables::set_material(const Material& material, int tag) {
  materials_[static_cast<std::size_t>(tag)] = material;
  ++changes_;
  device_.write_memory(wire::kMaterials.base + static_cast<std::size_t>(tag) * wire::kMaterialBytes,
                       wire::encoded(material_record(material)));
  if (irradiance_words_ == 1) return;
  device_.write_memory(wire::kScatteringColours.base + static_cast<std::size_t>(tag) * wire::kScatteringColourBytes,
                       wire::encoded(scattering_colour_record(material)));
}

void Tables::restore() {
  gradients_sent_ = false;
  segmentation_.assign(wire::kSegmentationEntries, {});
  reflectance_.clear();
  flags_.clear();
  ++changes_;
  for (std::size_t tag = 0; tag < materials_.size(); ++tag) set_material(materials_[tag], static_cast<int>(tag));
}

void Tables::Source::state(Archive::Record& record) {
  record(changes);
  record.at_most(light, SampleLight::kIncident);
  record(range, towards_eye);
}

void Tables::state(Archive& archive) {
  archive("wide", wide_);
  archive("irradiance_words", irradiance_words_);
  std::vector<Vec3> directions;
  if (codebook_) directions.assign(codebook_->given().begin(), codebook_->given().end());
  archive.list("codebook", directions, wire::kGradientCodes);
  if (archive.loads()) {
    try {
      codebook_.reset();
      if (!directions.empty()) codebook_.emplace(directions);
    } catch (const BadArgument& fault) {
      archive.refuse(fault.field(), fault.expected(), fault.got());
    }
  }
  archive("gradients_sent", gradients_sent_);
  for (std::size_t tag = 0; tag < functions_.size(); ++tag) {
    archive.within("tag" + std::to_string(tag), [&] {
      state_of(archive, "function", functions_[tag], static_cast<int>(tag));
      state_of(archive, "material", materials_[tag]);
    });
  }
  std::vector<std::uint8_t> words;
  if (!archive.loads()) {
    for (const wire::SegmentationEntry& entry : segmentation_) wire::append(words, entry);
  }
  constexpr std::size_t kBytes = wire::kSegmentationEntries * wire::kSegmentationEntryBytes;
  archive.bytes("segmentation", words, kBytes, kBytes);
  for (std::size_t i = 0; archive.loads() && i < segmentation_.size(); ++i) {
    segmentation_[i] =
        wire::decode<wire::SegmentationEntry>(std::span(words).subspan(i * wire::kSegmentationEntryBytes));
  }
  archive("shading", shading_);
  if (archive.loads()) {
    try {
      check(shading_);
    } catch (const BadArgument& fault) {
      archive.refuse("shading." + fault.field(), fault.expected(), fault.got());
    }
  }
  archive.at_most("light", light_, SampleLight::kIncident);
  archive("changes", changes_);
  archive("segmentation_source", segmentation_source_);
  archive("reflectance_source", reflectance_source_);
  archive.bytes("reflectance", reflectance_, 0, wire::kReflectanceBytes);
  archive.bytes("flags", flags_, 0, wire::kEmptyFlags.bytes);
}

void Tables::send_segmentation(ValueRange range) {
  constexpr std::size_t kQuarter = wire::kSegmentationEntries / wire::kTags;
  const Source source{changes_, light_, range, {}};
  if (source == segmentation_source_) return;
  for (std::size_t tag = 0; tag < functions_.size(); ++tag) {
    if (!functions_[tag]) continue;
    auto wanted = segmentation_entries(*functions_[tag], range, shading_.phong, wide_);
    if (light_ == SampleLight::kAbsorbed) set_gains(wanted, scattering_by_colour(materials_[tag]));
    if (light_ == SampleLight::kIncident) set_unit_gains(wanted);
    const auto held = std::span(segmentation_).subspan(tag * kQuarter, kQuarter);
    if (std::equal(wanted.begin(), wanted.end(), held.begin(), held.end())) continue;
    std::vector<std::uint8_t> bytes(kQuarter * wire::kSegmentationEntryBytes);
    for (std::size_t i = 0; i < kQuarter; ++i) {
      wire::encode(wanted[i], std::span(bytes).subspan(i * wire::kSegmentationEntryBytes));
    }
    device_.write_memory(wire::kSegmentationLut.base + tag * bytes.size(), bytes);
    std::copy(wanted.begin(), wanted.end(), held.begin());
  }
  segmentation_source_ = source;
}

void Tables::send_reflectance(Vec3 towards_eye) {
  const Source source{changes_, light_, {}, towards_eye};
  if (source == reflectance_source_) return;
  Phong phong = shading_.phong;
  if (light_ != SampleLight::kMap) phong.diffuse = 0;
  auto wanted = reflectance_map(phong, shading_.light, towards_eye);
  if (wanted != reflectance_) device_.write_memory(wire::kReflectanceMap.base, wanted);
  reflectance_ = std::move(wanted);
  reflectance_source_ = source;
}

void Tables::send_flags(std::span<const std::uint8_t> flags) {
  auto wanted = pack_flags(flags);
  flags_.resize(wanted.size());
  if (wanted == flags_) return;
  device_.write_memory(wire::kEmptyFlags.base, wanted);
  flags_ = std::move(wanted);
}

}  // namespace gicube
