// The ring of links (asic/link/ring.h, [P §2.1, §3.6]): a ray takes the shorter way round, to the right if both are
// equally long. Rays in transit precede those that enter, and one place of a direction stays free, so that the ring
// cannot deadlock.
module ring #(
    parameter int unsigned PROCESSORS = 4,  // at least 2
    parameter int unsigned TOKEN = 64,
    parameter int unsigned PROCESSOR_AT = 0,
    parameter int unsigned RAYS = 4,
    parameter int unsigned CYCLES = 8
) (
    input  logic                        clk,
    input  logic                        rst,
    // By processor.
    input  logic [PROCESSORS-1:0]       leaves,
    input  logic [PROCESSORS*TOKEN-1:0] leaving,
    output logic [PROCESSORS-1:0]       enters,
    input  logic [PROCESSORS-1:0]       left_ready,
    output logic [PROCESSORS-1:0]       from_left,
    output logic [PROCESSORS*TOKEN-1:0] from_left_token,
    input  logic [PROCESSORS-1:0]       right_ready,
    output logic [PROCESSORS-1:0]       from_right,
    output logic [PROCESSORS*TOKEN-1:0] from_right_token,
    // Counts, of the link to the right in the lower half and of that to the left in the upper.
    output logic [2*PROCESSORS-1:0]     hops,
    output logic [2*PROCESSORS-1:0]     busy,
    output logic [2*PROCESSORS-1:0]     blocked,
    output logic [PROCESSORS-1:0]       waits
);
  localparam int unsigned P = PROCESSORS;
  logic [P-1:0] enters_right, enters_left;
  logic [2*P-1:0] can_push, can_enter, arrives, goes_on;
  logic [2*P*TOKEN-1:0] fronts;

  assign hops = arrives | goes_on;
  assign enters = enters_right | enters_left;
  assign waits = leaves & ~enters;

  for (genvar i = 0; i < P; i++) begin : gen_processor
    localparam int unsigned RIGHT = (i + 1) % P;
    localparam int unsigned LEFT = (i + P - 1) % P;
    logic [TOKEN-1:0] mine;
    logic [7:0] to, distance;
    logic goes_right;
    assign mine = leaving[i*TOKEN +: TOKEN];
    assign to = mine[PROCESSOR_AT +: 8];
    assign distance = to > 8'(i) ? to - 8'(i) : to + 8'(P - i);  // to the right
    assign goes_right = distance <= 8'(P) - distance;
    assign enters_right[i] = leaves[i] && goes_right && can_enter[i] && !goes_on[LEFT];
    assign enters_left[i] = leaves[i] && !goes_right && can_enter[P+i] && !goes_on[P+RIGHT];

    link #(.TOKEN(TOKEN), .PROCESSOR_AT(PROCESSOR_AT), .RAYS(RAYS), .CYCLES(CYCLES), .END(RIGHT)) to_right (
        .clk, .rst, .push(enters_right[i] || goes_on[LEFT]),
        .push_token(goes_on[LEFT] ? fronts[LEFT*TOKEN +: TOKEN] : mine), .can_push(can_push[i]),
        .can_enter(can_enter[i]), .arrival_ready(left_ready[RIGHT]), .next_ready(can_push[RIGHT]), .arrives(arrives[i]),
        .goes_on(goes_on[i]), .front(fronts[i*TOKEN +: TOKEN]), .busy(busy[i]), .blocked(blocked[i]));
    link #(.TOKEN(TOKEN), .PROCESSOR_AT(PROCESSOR_AT), .RAYS(RAYS), .CYCLES(CYCLES), .END(LEFT)) to_left (
        .clk, .rst, .push(enters_left[i] || goes_on[P+RIGHT]),
        .push_token(goes_on[P+RIGHT] ? fronts[(P+RIGHT)*TOKEN +: TOKEN] : mine), .can_push(can_push[P+i]),
        .can_enter(can_enter[P+i]), .arrival_ready(right_ready[LEFT]), .next_ready(can_push[P+LEFT]),
        .arrives(arrives[P+i]), .goes_on(goes_on[P+i]), .front(fronts[(P+i)*TOKEN +: TOKEN]), .busy(busy[P+i]),
        .blocked(blocked[P+i]));
    assign from_left[i] = arrives[LEFT];
    assign from_left_token[i*TOKEN +: TOKEN] = fronts[LEFT*TOKEN +: TOKEN];
    assign from_right[i] = arrives[P+RIGHT];
    assign from_right_token[i*TOKEN +: TOKEN] = fronts[(P+RIGHT)*TOKEN +: TOKEN];
  end
endmodule
