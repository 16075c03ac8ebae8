#include "gicube/wire/command.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(RenderCommand, HasTheBytesThatItsTableSays) {
  RenderCommand command;
  command.width = 512;   // 0x200
  command.height = 256;  // 0x100
  command.projection = Projection::kPerspective;
  command.samples_per_axis = 2;
  command.filter = Filter::kTent;
  command.lamps = 3;
  command.strip_rows = 16;
  command.part = 2;
  command.parts = 5;
  command.origin = {1, -2, 0.5};  // 3FF, C00, 3FE and thirteen zeros
  command.forward = {0, 0, 1};
  command.du = {0.25, 0, 0};   // 3FD
  command.dv = {0, -0.25, 0};  // BFD
  const std::string zero = " 00 00 00 00 00 00 00 00";
  EXPECT_EQ(hex_of<kRenderCommandBytes>(command),
            "01 00 00 00 00 02 00 01 01 02 01 03 10 00 02 05"
            " 00 00 00 00 00 00 F0 3F 00 00 00 00 00 00 00 C0 00 00 00 00 00 00 E0 3F" +
                zero + zero + " 00 00 00 00 00 00 F0 3F" +  // forward
                " 00 00 00 00 00 00 D0 3F" + zero + zero +  // du
                zero + " 00 00 00 00 00 00 D0 BF" + zero);  // dv
}

RC_GTEST_PROP(RenderCommand, ComesBackAsItWas, ()) {
  const RenderCommand command = any_render();
  RC_ASSERT(decode<RenderCommand>(encoded<kRenderCommandBytes>(command)) == command);
}

TEST(Lamp, HasTheBytesThatItsTableSays) {
  const Lamp lamp{.kind = LightKind::kSphere,
                  .colour = {65536, 32768, 0x00ABCDEF},
                  .position = {1, -2, 0.5},
                  .u = {0.25, 0, 0},
                  .v = {0, -0.25, 0}};
  const std::string zero = " 00 00 00 00 00 00 00 00";
  EXPECT_EQ(hex_of<kLampBytes>(lamp),
            "03 00 00 00 00 00 01 00 00 80 00 00 EF CD AB 00"
            " 00 00 00 00 00 00 F0 3F 00 00 00 00 00 00 00 C0 00 00 00 00 00 00 E0 3F"
            " 00 00 00 00 00 00 D0 3F" +
                zero + zero +                               // u
                zero + " 00 00 00 00 00 00 D0 BF" + zero);  // v
}

RC_GTEST_PROP(Lamp, ComesBackAsItWas, ()) {
  const Lamp lamp = any_lamp();
  RC_ASSERT(decode<Lamp>(encoded<kLampBytes>(lamp)) == lamp);
}

}  // namespace
}  // namespace gicube::wire
