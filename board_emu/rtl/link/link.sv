// A link to a neighbour, with its entry queue (asic/link/ring.h). A ray is on it for CYCLES cycles and is passed on
// in the last of them, to the processor at its END or to the next link.
module link #(
    parameter int unsigned TOKEN = 64,
    parameter int unsigned PROCESSOR_AT = 0,  // first of the 8 bits of the ray's destination
    parameter int unsigned RAYS = 4,
    parameter int unsigned CYCLES = 8,
    parameter int unsigned END = 0,
    localparam int unsigned COUNT_BITS = $clog2(RAYS + 1)
) (
    input  logic             clk,
    input  logic             rst,
    input  logic             push,
    input  logic [TOKEN-1:0] push_token,
    output logic             can_push,
    output logic             can_enter,  // room for a ray that enters the ring, which leaves one place free
    input  logic             arrival_ready,
    input  logic             next_ready,
    output logic             arrives,
    output logic             goes_on,  // to the next link
    output logic [TOKEN-1:0] front,
    output logic             busy,
    output logic             blocked
);
  localparam int unsigned SENT_BITS = CYCLES > 1 ? $clog2(CYCLES) : 1;
  logic [SENT_BITS-1:0] sent  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] size;
  logic has_ray, is_last, at_end;

  assign has_ray = size != '0;
  assign can_push = size < COUNT_BITS'(RAYS);
  assign can_enter = size <= COUNT_BITS'(RAYS - 2);
  assign is_last = sent == SENT_BITS'(CYCLES - 1);
  assign at_end = front[PROCESSOR_AT +: 8] == 8'(END);
  assign arrives = has_ray && is_last && at_end && arrival_ready;
  assign goes_on = has_ray && is_last && !at_end && next_ready;
  assign blocked = has_ray && is_last && !arrives && !goes_on;
  assign busy = has_ray && !blocked;

  fifo #(.WIDTH(TOKEN), .PLACES(RAYS)) entry (
      .clk, .rst, .push, .push_item(push_token), .pop(arrives || goes_on), .front, .size);

  always_ff @(posedge clk) begin
    if (rst || arrives || goes_on) sent <= '0;
    else if (has_ray && !is_last) sent <= sent + 1'b1;
  end
endmodule
