// Pictures of a board's volume (Board::renderer()).
#pragma once

#include <span>
#include <string>

#include "gicube/export.h"
#include "gicube/image.h"
#include "gicube/pending.h"
#include "gicube/view.h"

namespace gicube {

struct BoardState;

class GICUBE_API Renderer {
 public:
  explicit Renderer(BoardState& of) : state_(&of) {}

  // Renders and transfers the picture; the simulated host waits for both. Throws as the two calls below.
  Image render(const View& view, const Progress& progress = {});
  // Checks nothing: every error of the picture comes from Pending::get(). Throws Error in a callback of this Board,
  // std::system_error if no thread can be started.
  Pending<Image> start(const View& view);

  // Renders into the board's framebuffer; the simulated host waits for its completion but does not read the image.
  // Throws BadArgument (view's fields), Rejected (no volume, no scattering routine) and Unsupported (the application's
  // scattering routine in a volume that the card does not store whole): the framebuffer is unchanged.
  void render_to_framebuffer(const View& view, const Progress& progress = {});
  // Transfers the framebuffer at 36 bits per pixel. Throws Rejected before the first rendering.
  Image read_framebuffer();
  // Reads into the caller's memory, rows from the top. Throws BadArgument, too, if it has not as many pixels as the
  // picture.
  void read_framebuffer(std::span<Pixel> pixels);

  // Empty if something is visible in a picture of this board: a colour, or an alpha of a step of 8 bits. Otherwise a
  // sentence for people, which ends with the likely reason: no transfer function, values that it does not show, empty
  // flags, a camera that looks elsewhere, cut planes. The last view rendered is taken into account. It costs no
  // simulated time.
  std::string why_invisible(const Image& image) const;

 private:
  BoardState* state_;
};

}  // namespace gicube
