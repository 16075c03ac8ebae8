// Rendering and the framebuffer.
#include "fields.h"

namespace gicube::c_api {
namespace {

View to_view(const gicube_view* given) {
  gicube_view record;
  View view = read_fields<gicube_view, View>("view", given, record);
  constexpr std::uint32_t kMax = 6;
  if (record.cut_plane_count > kMax) {
    throw BadArgument("view.cut_plane_count", "at most 6", std::to_string(record.cut_plane_count));
  }
  checked("view.cut_planes", record.cut_planes, record.cut_plane_count);
  for (std::uint32_t i = 0; i < record.cut_plane_count; ++i) {
    view.cut_planes.push_back({to_vec3(record.cut_planes[i].normal), record.cut_planes[i].offset});
  }
  return view;
}

// The picture that there is now; what another thread renders meanwhile is its own affair.
std::size_t pixels_of(std::pair<int, int> size) {
  return static_cast<std::size_t>(size.first) * static_cast<std::size_t>(size.second);
}

void render(gicube_board& handle, const View& view, const Progress& progress) {
  handle.board.render_to_framebuffer(view, progress);
  const std::scoped_lock lock(handle.mutex);
  handle.framebuffer = {view.width, view.height};
}

void read(gicube_board& handle, gicube_pixel* pixels, std::size_t count) {
  const Image image = handle.board.read_framebuffer();
  check_count("count", count, image.pixels.size());
  for (const Pixel& pixel : image.pixels) *pixels++ = {pixel.red, pixel.green, pixel.blue, 0, pixel.alpha};
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_render_to_framebuffer(gicube_board* board, const gicube_view* view, gicube_progress progress,
                                           void* user) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    render(handle, to_view(view), to_progress(progress, user));
  });
}

gicube_status gicube_get_framebuffer_size(gicube_board* board, int32_t* width, int32_t* height) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    checked("width", width);
    checked("height", height);
    const std::scoped_lock lock(handle.mutex);
    *width = handle.framebuffer.first;
    *height = handle.framebuffer.second;
  });
}

gicube_status gicube_read_framebuffer(gicube_board* board, gicube_pixel* pixels, size_t count) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    checked("pixels", pixels);
    std::size_t there = 0;
    {
      const std::scoped_lock lock(handle.mutex);
      there = pixels_of(handle.framebuffer);
    }
    if (there > 0) check_count("count", count, there);  // before anything is transferred; else the board says why not
    read(handle, pixels, count);
  });
}

gicube_status gicube_render(gicube_board* board, const gicube_view* view, gicube_pixel* pixels, size_t count,
                            gicube_progress progress, void* user) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    const gicube::View picture = to_view(view);
    checked("pixels", pixels);
    if (picture.width > 0 && picture.height > 0) {  // else the driver names what is wrong with them
      check_count("count", count, pixels_of({picture.width, picture.height}));
    }
    render(handle, picture, to_progress(progress, user));
    read(handle, pixels, count);
  });
}
}
