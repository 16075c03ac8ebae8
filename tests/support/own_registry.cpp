// In every test program: its boards, of which it may kill some, are not registered with the user's.
#include "own_registry.h"

namespace gicube::reference {
namespace {

const OwnRegistry kOfThisProgram;

}  // namespace
}  // namespace gicube::reference
