// In every test program: its boards are those of this build, which stand in another folder, and since it may kill some,
// they are not registered with the user's.
#include "own_registry.h"

namespace gicube::reference {
namespace {

const OwnRegistry kOfThisProgram;
[[maybe_unused]] const int kBoardIsNamed = ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);

}  // namespace
}  // namespace gicube::reference
