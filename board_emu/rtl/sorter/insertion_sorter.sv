// The pipelined insertion sorter of [P Figure 7] (asic/sorter/insertion_sorter.h): one rank per queue, each with a
// selected and a comparison buffer. An item is {importance, ~queue}, so that of equal importances the lower queue
// number is larger; importance 0 is a hole, all ones is infinite.
//
// A cycle has four steps, one behind the other: all ranks compare; the top becomes active; all ranks move up by one;
// one item enters the top's comparison buffer and its old copy is wiped.
module insertion_sorter #(
    parameter int unsigned QUEUES = 128,
    parameter int unsigned QUEUE_BITS = 7,
    parameter int unsigned IMPORTANCE_BITS = 9
) (
    input  logic                       clk,
    input  logic                       rst,
    // After the comparisons of this cycle.
    output logic                       has_top,
    output logic [QUEUE_BITS-1:0]      top,
    output logic                       has_items,
    input  logic                       activate_top,
    input  logic                       shift_up,
    output logic                       can_insert,  // after shift_up
    input  logic                       insert,
    input  logic [QUEUE_BITS-1:0]      insert_queue,
    input  logic [IMPORTANCE_BITS-1:0] insert_importance
);
  localparam int unsigned ITEM = IMPORTANCE_BITS + QUEUE_BITS;
  localparam int unsigned ALL = QUEUES * ITEM;

  logic [ALL-1:0] selected  /* verilator public_flat_rd */;
  logic [ALL-1:0] comparison  /* verilator public_flat_rd */;
  logic [ALL-1:0] compared_selected, compared_comparison, shifted_selected, shifted_comparison;
  logic [ALL-1:0] next_selected, next_comparison;
  logic [QUEUES-1:0] holds;

  // The larger of a rank's two items stays, the smaller goes to the rank below. Nothing falls out of the last rank,
  // because there are no more items than ranks.
  for (genvar r = 0; r < QUEUES; r++) begin : gen_rank
    logic [ITEM-1:0] mine, other;
    logic other_is_larger;
    assign mine = selected[r*ITEM +: ITEM];
    assign other = comparison[r*ITEM +: ITEM];
    assign other_is_larger = other > mine;
    assign compared_selected[r*ITEM +: ITEM] = other_is_larger ? other : mine;
    if (r + 1 < QUEUES) begin : gen_below
      assign compared_comparison[(r+1)*ITEM +: ITEM] = other_is_larger ? mine : other;
    end
    assign holds[r] = (|mine) | (|other);
  end
  assign compared_comparison[ITEM-1:0] = '0;

  assign has_items = |holds;
  assign has_top = |compared_selected[QUEUE_BITS +: IMPORTANCE_BITS];
  assign top = ~compared_selected[QUEUE_BITS-1:0];

  always_comb begin
    shifted_selected = compared_selected;
    if (activate_top) shifted_selected[QUEUE_BITS +: IMPORTANCE_BITS] = '1;
    shifted_comparison = compared_comparison;
    if (shift_up) begin
      shifted_selected = shifted_selected >> ITEM;
      shifted_comparison = shifted_comparison >> ITEM;
    end
  end
  assign can_insert = shifted_comparison[ITEM-1:0] == '0;

  for (genvar r = 0; r < QUEUES; r++) begin : gen_wipe
    logic [ITEM-1:0] one;
    assign one = shifted_selected[r*ITEM +: ITEM];
    assign next_selected[r*ITEM +: ITEM] = insert && one[QUEUE_BITS-1:0] == ~insert_queue ? '0 : one;
    if (r > 0) begin : gen_lower
      logic [ITEM-1:0] two;
      assign two = shifted_comparison[r*ITEM +: ITEM];
      assign next_comparison[r*ITEM +: ITEM] = insert && two[QUEUE_BITS-1:0] == ~insert_queue ? '0 : two;
    end
  end
  assign next_comparison[ITEM-1:0] =
      insert ? {insert_importance, ~insert_queue} : shifted_comparison[ITEM-1:0];

  always_ff @(posedge clk) begin
    selected   <= rst ? '0 : next_selected;
    comparison <= rst ? '0 : next_comparison;
  end
endmodule
