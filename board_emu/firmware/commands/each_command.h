// The DSP's commands. Each checks its payload, has its rays traced by the card's level, and reports its cost. They
// throw CommandFault.
#pragma once

#include "card.h"

namespace gicube::emu {

using Command = CommandResult(Card& card, Payload payload, Progress& work);

Command render_image, trace_rays, illuminate_volume, resume_rays, verify_blocks, trace_pairs, continue_rays, take_rays,
    give_rays, load_coarse;

// Throws CommandFault with the faulty field's name. Does not check `count`.
void check_trace_header(const wire::TraceHeader& header);

// Configures the frame for rays of this type, which must not deposit.
void set_type(Frame& frame, const wire::TraceHeader& header);

}  // namespace gicube::emu
