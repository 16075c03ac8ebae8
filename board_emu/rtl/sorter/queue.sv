// One ray queue with its own eDRAM, slots and importance (asic/sorter/queues.h, [P §3.2]). A cycle: a slot is
// released, a ray is read, a ray is written; at most one of each.
module queue #(
    parameter int unsigned RAYS = 256,
    parameter int unsigned TOKEN = 256,
    parameter int unsigned CONTRIBUTION_AT = 0,  // first of the token's 12 bits
    parameter int unsigned POLICY = 0,           // 0 most_rays, 1 most_contribution, 2 longest_wait
    parameter int unsigned IMPORTANCE_BITS = 9,
    localparam int unsigned PLACE_BITS = $clog2(RAYS),
    localparam int unsigned COUNT_BITS = $clog2(RAYS + 1)
) (
    input  logic                       clk,
    input  logic                       rst,
    input  logic                       released,
    output logic                       reserves,  // the released slot is reserved for an overflowed ray
    // Free slots after the release.
    output logic                       has_slot,
    output logic                       has_two_slots,
    input  logic                       read,
    output logic [TOKEN-1:0]           front,
    output logic                       is_open,   // rays wait after the read
    input  logic                       overflows,
    input  logic                       write,
    input  logic                       write_reserved,  // the ray has its slot already
    input  logic [TOKEN-1:0]           write_token,
    input  logic [IMPORTANCE_BITS-1:0] write_opening,   // number of the opening, if the queue is not open
    output logic                       is_empty,        // after the write
    output logic [IMPORTANCE_BITS-1:0] importance
);
  localparam int unsigned SUM_BITS = COUNT_BITS + 12;

  logic [TOKEN-1:0] edram [RAYS]  /* verilator public_flat_rd */;
  logic [PLACE_BITS-1:0] head  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] waiting  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] slots  /* verilator public_flat_rd */;
  logic [19:0] overflowed  /* verilator public_flat_rd */;  // rays without a reserved slot; the DSP has room for 2^19
  logic [IMPORTANCE_BITS-1:0] opened  /* verilator public_flat_rd */;
  logic [SUM_BITS-1:0] contribution;  // sum over the waiting rays, at least 1 each

  logic [COUNT_BITS-1:0] slots_left, rest, next_waiting;
  logic [SUM_BITS-1:0] next_contribution;
  logic [IMPORTANCE_BITS-1:0] next_opened;
  logic [PLACE_BITS-1:0] tail;

  function automatic logic [SUM_BITS-1:0] weight(input logic [11:0] of);
    weight = of == 12'd0 ? SUM_BITS'(1) : SUM_BITS'(of);
  endfunction

  assign reserves = released && overflowed != 20'd0;
  assign slots_left = slots - COUNT_BITS'(released && !reserves);
  assign has_slot = slots_left < COUNT_BITS'(RAYS);
  assign has_two_slots = slots_left < COUNT_BITS'(RAYS - 1);
  assign front = edram[head];
  assign rest = waiting - COUNT_BITS'(read);
  assign is_open = rest != '0;
  assign next_waiting = rest + COUNT_BITS'(write);
  assign is_empty = next_waiting == '0;
  assign tail = PLACE_BITS'((COUNT_BITS+1)'(head) + (COUNT_BITS+1)'(waiting) >= (COUNT_BITS+1)'(RAYS) ?
                            (COUNT_BITS+1)'(head) + (COUNT_BITS+1)'(waiting) - (COUNT_BITS+1)'(RAYS) :
                            (COUNT_BITS+1)'(head) + (COUNT_BITS+1)'(waiting));
  assign next_contribution = contribution - (read ? weight(front[CONTRIBUTION_AT +: 12]) : '0)
                             + (write ? weight(write_token[CONTRIBUTION_AT +: 12]) : '0);
  assign next_opened = write && !is_open ? write_opening : opened;

  if (POLICY == 0) begin : gen_most_rays
    assign importance = IMPORTANCE_BITS'(next_waiting);
  end else if (POLICY == 1) begin : gen_most_contribution
    assign importance = IMPORTANCE_BITS'(next_contribution);
  end else begin : gen_longest_wait
    localparam logic [IMPORTANCE_BITS-1:0] MOST = ~IMPORTANCE_BITS'(1);
    assign importance = is_empty ? '0 : next_opened < MOST ? MOST - next_opened : IMPORTANCE_BITS'(1);
  end

  always_ff @(posedge clk) begin
    if (write) edram[tail] <= write_token;
    if (rst) begin
      head <= '0;
      waiting <= '0;
      slots <= '0;
      overflowed <= '0;
      opened <= '0;
      contribution <= '0;
    end else begin
      if (read) head <= head == PLACE_BITS'(RAYS - 1) ? '0 : head + 1'b1;
      waiting <= next_waiting;
      slots <= slots_left + COUNT_BITS'(write && !write_reserved);
      overflowed <= overflowed - 20'(reserves) + 20'(overflows);
      opened <= next_opened;
      contribution <= next_contribution;
    end
  end
endmodule
