// A registered FIFO between two parts (asic/sim/fifo.h): a push or pop takes effect at the clock edge that ends its
// cycle. Place 0 is the front; a pop moves all items down by one place.
module fifo #(
    parameter int unsigned WIDTH  = 32,
    parameter int unsigned PLACES = 2,
    localparam int unsigned COUNT_BITS = $clog2(PLACES + 1)
) (
    input  logic                  clk,
    input  logic                  rst,
    input  logic                  push,  // only if size < PLACES
    input  logic [WIDTH-1:0]      push_item,
    input  logic                  pop,  // only if size > 0
    output logic [WIDTH-1:0]      front,
    output logic [COUNT_BITS-1:0] size  /* verilator public_flat_rd */
);
  logic [PLACES*WIDTH-1:0] items  /* verilator public_flat_rd */;
  logic [PLACES*WIDTH-1:0] next_items;
  logic [COUNT_BITS-1:0] kept;

  assign front = items[WIDTH-1:0];
  assign kept = size - COUNT_BITS'(pop);

  always_comb begin
    next_items = pop ? items >> WIDTH : items;
    for (int unsigned i = 0; i < PLACES; i++) begin
      if (push && kept == COUNT_BITS'(i)) next_items[i*WIDTH +: WIDTH] = push_item;
    end
  end

  always_ff @(posedge clk) begin
    items <= next_items;
    size  <= rst ? '0 : kept + COUNT_BITS'(push);
  end
endmodule
