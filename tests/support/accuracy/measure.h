// One scene's figures: the board's picture and each quantiser alone, against the reference without quantisers.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "gicube/board.h"
#include "reference/compare.h"
#include "scenes.h"

namespace gicube::accuracy {

struct NamedQuantiser {
  std::string_view name;
  bool reference::Quantisers::*quantiser;
};

inline constexpr std::array<NamedQuantiser, 7> kQuantisers{{{"density", &reference::Quantisers::density},
                                                            {"gradient", &reference::Quantisers::gradient},
                                                            {"colour", &reference::Quantisers::colour},
                                                            {"opacity", &reference::Quantisers::opacity},
                                                            {"reflectance", &reference::Quantisers::reflectance},
                                                            {"position", &reference::Quantisers::position},
                                                            {"framebuffer", &reference::Quantisers::framebuffer}}};

// The board's picture of a scene, by the public driver alone. Throws the driver's errors.
Image render_on_board(const samples::SceneSetup& setup, Board& board);

struct Figures {
  Dims dims{};
  int width = 0, height = 0;
  double step = 0;  // voxels
  reference::Difference board;
  std::array<reference::Difference, kQuantisers.size()> alone;  // in the order of kQuantisers
  reference::Difference together;                               // the reference with all quantisers
  reference::Difference unexplained;                            // the board against the reference with all quantisers
};

// `threads` of the reference, 0 = one a core.
Figures measure(const samples::SceneSetup& setup, Board& board, unsigned threads = 0);

// The URI with what a scene needs of an emulated board added to its query.
std::string uri_for(const StudyScene& study, const std::string& uri);

}  // namespace gicube::accuracy
