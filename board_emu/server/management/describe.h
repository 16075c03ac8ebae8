// Fills messages of the management plane with a board's public state. Thread-safe.
#pragma once

#include "gicube/v1/management.pb.h"
#include "server/bus/board_slot.h"

namespace gicube::emu {

void describe(const BoardSlot& slot, v1::BoardInfo& out);
void describe(const BoardSlot& slot, v1::CounterSnapshot& out);
void describe(const BoardSlot& slot, v1::TraceInfo& out);
void describe(BoardSlot& slot, v1::FaultPlanInfo& out);

}  // namespace gicube::emu
