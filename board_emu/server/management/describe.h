// What may be seen of a board from outside, as messages of the management plane. Any thread.
#pragma once

#include "gicube/v1/management.pb.h"
#include "server/bus/board_slot.h"

namespace gicube::emu {

void describe(const BoardSlot& slot, v1::BoardInfo& out);
void describe(const BoardSlot& slot, v1::CounterSnapshot& out);
void describe(const BoardSlot& slot, v1::TraceInfo& out);
void describe(BoardSlot& slot, v1::FaultPlanInfo& out);

}  // namespace gicube::emu
