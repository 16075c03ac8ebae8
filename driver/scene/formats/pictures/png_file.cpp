#include "scene/formats/pictures/png_file.h"

#include <png.h>

#include <csetjmp>
#include <new>

#include "gicube/scene/error.h"

namespace gicube::scene {
namespace {

struct Target {
  std::vector<std::uint8_t> bytes;
  std::string error;
};

// Exceptions must not pass through libpng, which is C.
void append(png_structp png, png_bytep data, std::size_t count) {
  auto& bytes = static_cast<Target*>(png_get_io_ptr(png))->bytes;
  bool is_added = true;
  try {
    bytes.insert(bytes.end(), data, data + count);
  } catch (const std::bad_alloc&) {
    is_added = false;
  }
  if (!is_added) png_error(png, "no memory");
}

[[noreturn]] void fail(png_structp png, const char* message) {
  static_cast<Target*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void ignore(png_structp, const char*) {}  // warnings

// libpng reports an error by a jump to here. No destructor is skipped: all objects belong to the caller.
bool write(png_structp png, png_infop info, const PngToWrite& picture, std::vector<png_text>& texts) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width), static_cast<png_uint_32>(picture.height), 8,
               picture.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_ABSOLUTE);
  png_set_text(png, info, texts.data(), static_cast<int>(texts.size()));
  png_write_info(png, info);
  const auto row = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.channels);
  for (int y = 0; y < picture.height; ++y) {
    png_write_row(png, picture.samples.data() + row * static_cast<std::size_t>(y));
  }
  png_write_end(png, nullptr);
  return true;
}

}  // namespace

std::vector<std::uint8_t> encoded_png(const std::filesystem::path& file, const PngToWrite& picture) {
  Target target;
  std::vector<png_text> texts;
  for (const auto& [key, text] : picture.texts) {
    png_text& entry = texts.emplace_back();
    entry.compression = PNG_TEXT_COMPRESSION_NONE;
    entry.key = const_cast<char*>(key.c_str());  // libpng does not write to them
    entry.text = const_cast<char*>(text.c_str());
    entry.text_length = text.size();
  }
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &target, &fail, &ignore);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  bool written = false;
  if (info != nullptr) {
    png_set_write_fn(png, &target, &append, nullptr);
    written = write(png, info, picture, texts);
  }
  png_destroy_write_struct(&png, &info);
  if (!written) throw FileError(file, "picture", "one that libpng can write", target.error);
  return std::move(target.bytes);
}

}  // namespace gicube::scene
