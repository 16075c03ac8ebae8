// The rows of an image that a card renders: all, or every n-th strip.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "gicube/archive.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

inline constexpr int kSubPixels = 16;  // u and v of a ray are 12.4 pixels

class ImageRows {
 public:
  // All rows of an image of this height.
  ImageRows(int height = 0) : height_(height), count_(height), strip_(std::max(height, 1)) {}
  // The rows of a command. At least one strip must be in the image.
  explicit ImageRows(const wire::RenderCommand& command) : ImageRows(command.height) {
    if (command.parts == 0) return;
    count_ = wire::rows_of(command);
    strip_ = command.strip_rows;
    part_ = command.part;
    parts_ = command.parts;
  }

  friend bool operator==(const ImageRows&, const ImageRows&) = default;
  int count() const { return count_; }
  void state(Archive& archive) {
    archive.field("rows", [this](Archive::Record& record) {
      record.at_most(height_, 0xFFFF);
      record.at_most(strip_, 0xFFFF);
      record.at_most(part_, 0xFF);
      record.at_most(parts_, 0xFF);
      if (!record.loads()) return;
      record.expect(strip_ >= 1, "a strip of rows", static_cast<std::uint64_t>(strip_));
      record.expect(part_ < parts_, "a part of the image's", static_cast<std::uint64_t>(part_));
      wire::RenderCommand command;
      command.height = static_cast<std::uint16_t>(height_);
      command.strip_rows = static_cast<std::uint16_t>(strip_);
      command.part = static_cast<std::uint8_t>(part_);
      command.parts = static_cast<std::uint8_t>(parts_);
      count_ = wire::rows_of(command);
    });
  }
  // Index of an image row among the card's rows; -1 if it is not one of them.
  int place(int row) const {
    if (row < 0 || row >= height_) return -1;
    if (parts_ == 1) return row;
    const int strip = row / strip_;
    return strip % parts_ == part_ ? strip / parts_ * strip_ + row % strip_ : -1;
  }

  // The sample rows of the image, from the top, that contribute to these pixel rows. With a tent filter this includes
  // samples in the rows next to a strip.
  std::vector<std::uint16_t> sample_rows(int samples_per_axis, wire::Filter filter) const {
    std::vector<std::uint16_t> rows;
    const int spacing = kSubPixels / samples_per_axis;
    for (int row = 0; row < height_ * samples_per_axis; ++row) {
      if (counts(row * spacing + spacing / 2, filter)) rows.push_back(static_cast<std::uint16_t>(row));
    }
    return rows;
  }

 private:
  bool counts(int v, wire::Filter filter) const {
    const int own = v / kSubPixels;
    if (place(own) >= 0) return true;
    if (filter == wire::Filter::kBox) return false;
    const int middle = own * kSubPixels + kSubPixels / 2;
    return v != middle && place(v < middle ? own - 1 : own + 1) >= 0;
  }

  int height_ = 0;  // rows of the whole image
  int count_ = 0;   // rows of this card
  int strip_ = 1;   // rows per strip
  int part_ = 0;
  int parts_ = 1;
};

}  // namespace gicube::emu
