// --explain-pixel: what the board tells of one pixel's rays, as JSON, as a table and as a picture.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "render/options.h"
#include "scene/program/board_options.h"

namespace gicube::samples {

// A file for the events of a private board; it is gone with this.
class EventFile {
 public:
  // Throws FileError if no temporary file can be made.
  EventFile();
  ~EventFile();
  EventFile(const EventFile&) = delete;
  EventFile& operator=(const EventFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string events_of;

 private:
  std::filesystem::path path_;
};

// Null: no pixel is to be explained.
std::unique_ptr<EventFile> events_for(const RenderOptions& options);
// The board's options with them.
BoardOptions with_events(BoardOptions board, const EventFile* events);

// The life of a pixel of the last picture in a file of events: the line "life" of docs/guide/observation.md. At the
// cycle level each iteration also has processor, cycle (its tags were checked), missing (packets), stalled (cycles that
// the pipeline was stalled for them), links (that the ray passed since the previous iteration) and overflows. Throws
// InputError if the board has refused the pixel, FileError.
nlohmann::ordered_json pixel_life(const std::filesystem::path& events);

// Lines for people.
std::string pixel_table(const nlohmann::ordered_json& life);
// SVG: a column a pass, a strip a ray.
std::string pixel_svg(const nlohmann::ordered_json& life);

}  // namespace gicube::samples
