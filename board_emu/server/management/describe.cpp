#include "describe.h"

namespace gicube::emu {

void describe(const BoardSlot& slot, v1::BoardInfo& out) {
  const BoardSlot::Info info = slot.info();
  out.set_board(info.index);
  out.set_product("GI-Cube (emulated)");
  out.set_version(GICUBE_VERSION);
  out.set_bus_endpoint(info.endpoint);
  out.set_in_use(info.in_use);
  if (info.in_use) out.set_owner(slot.owner());
  out.set_config_hash(config_hash_text(info.config));
  *out.mutable_config() = info.config;
  for (const RoutineInfo& routine : info.routines) {
    v1::ScatteringRoutine* listed = out.add_routines();
    listed->set_number(routine.number);
    listed->set_name(routine.name);
    listed->set_file(routine.file);
    listed->set_cycles(routine.cycles);
    listed->set_cycle_budget(routine.cycle_budget);
  }
}

void describe(const BoardSlot& slot, v1::CounterSnapshot& out) {
  const Board::Snapshot counted = slot.counters();
  out.set_board(slot.index());
  out.set_simulated_ps(counted.simulated_ps);
  for (const wire::Counter& counter : counted.counters) {
    v1::Counter* added = out.add_counters();
    added->set_name(counter.name);
    added->set_unit(counter.unit);
    added->set_value(counter.value);
  }
  const MachineLook& machine = counted.machine;
  if (machine.processors.empty()) return;
  v1::MachineLook& look = *out.mutable_machine();
  look.set_cycle(machine.cycle);
  look.set_blocks_a_side(machine.blocks_a_side);
  look.mutable_cells()->Add(machine.cells.begin(), machine.cells.end());
  look.mutable_waiting()->Add(machine.waiting.begin(), machine.waiting.end());
  look.mutable_processors()->Add(machine.processors.begin(), machine.processors.end());
  look.set_banks(machine.banks);
  for (const std::vector<std::uint64_t>& packets : machine.packets) {
    look.add_memories()->mutable_packets()->Add(packets.begin(), packets.end());
  }
}

void describe(const BoardSlot& slot, v1::TraceInfo& out) {
  out.set_board(slot.index());
  out.set_file(slot.trace_file());
}

void describe(BoardSlot& slot, v1::FaultPlanInfo& out) {
  const FaultPoint::Info info = slot.faults().info();
  out.set_board(slot.index());
  out.set_plan_text(info.plan_text);
  out.set_messages_down(info.messages_down);
  out.set_messages_up(info.messages_up);
  out.set_faults(info.faults);
}

}  // namespace gicube::emu
