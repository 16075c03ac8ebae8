// Numbers of queues whose importance has changed, in the order of the changes, each once (the list in
// asic/sorter/sorter.h). A cycle: the queue that becomes active leaves the list, two changed queues join it, its
// first is taken.
module changed_queues #(
    parameter int unsigned QUEUES = 128,
    parameter int unsigned QUEUE_BITS = 7,
    localparam int unsigned COUNT_BITS = $clog2(QUEUES + 1)
) (
    input  logic                  clk,
    input  logic                  rst,
    input  logic                  remove,
    input  logic [QUEUE_BITS-1:0] removed,
    input  logic [1:0]            change,  // the second queue differs from the first
    input  logic [QUEUE_BITS-1:0] changed_0,
    input  logic [QUEUE_BITS-1:0] changed_1,
    output logic                  has_first,  // after the changes
    output logic [QUEUE_BITS-1:0] first,
    input  logic                  take_first
);
  logic [QUEUES*QUEUE_BITS-1:0] list  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] count  /* verilator public_flat_rd */;
  logic [QUEUES*QUEUE_BITS-1:0] kept, longer;
  logic [COUNT_BITS-1:0] kept_count, longer_count;
  logic [QUEUES-1:0] is_removed, is_0, is_1;
  logic [QUEUES-2:0] goes_down;  // from the removed place up
  logic joins_0, joins_1;

  for (genvar i = 0; i < QUEUES; i++) begin : gen_place
    logic [QUEUE_BITS-1:0] here;
    logic is_used;
    assign here = list[i*QUEUE_BITS +: QUEUE_BITS];
    assign is_used = COUNT_BITS'(i) < count;
    assign is_removed[i] = remove && is_used && here == removed;
    assign is_0[i] = is_used && here == changed_0;
    assign is_1[i] = is_used && here == changed_1;
    if (i + 1 < QUEUES) begin : gen_moves
      assign kept[i*QUEUE_BITS +: QUEUE_BITS] = goes_down[i] ? list[(i+1)*QUEUE_BITS +: QUEUE_BITS] : here;
    end else begin : gen_last
      assign kept[i*QUEUE_BITS +: QUEUE_BITS] = here;
    end
    always_comb begin
      longer[i*QUEUE_BITS +: QUEUE_BITS] = kept[i*QUEUE_BITS +: QUEUE_BITS];
      if (joins_0 && kept_count == COUNT_BITS'(i)) longer[i*QUEUE_BITS +: QUEUE_BITS] = changed_0;
      if (joins_1 && kept_count + COUNT_BITS'(joins_0) == COUNT_BITS'(i))
        longer[i*QUEUE_BITS +: QUEUE_BITS] = changed_1;
    end
  end

  assign goes_down = (QUEUES-1)'(-is_removed);  // one bit of is_removed at most
  assign kept_count = count - COUNT_BITS'(|is_removed);
  assign joins_0 = change[0] && is_0 == '0;
  assign joins_1 = change[1] && is_1 == '0;
  assign longer_count = kept_count + COUNT_BITS'(joins_0) + COUNT_BITS'(joins_1);
  assign has_first = longer_count != '0;
  assign first = longer[QUEUE_BITS-1:0];

  always_ff @(posedge clk) begin
    list  <= take_first ? longer >> QUEUE_BITS : longer;
    count <= rst ? '0 : longer_count - COUNT_BITS'(take_first);
  end
endmodule
