#include "tables.h"

#include <algorithm>

#include "board/saved/saved_records.h"
#include "encode/lights.h"
#include "encode/look_up_tables.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/wire/memory_map.h"

namespace gicube {

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
