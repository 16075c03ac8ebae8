// Tags of one of the volume cache's eight banks: the block whose tile each place holds, or none.
module tag_bank #(
    parameter int unsigned PLACES = 16,
    parameter int unsigned BLOCK_BITS = 9,
    localparam int unsigned PLACE_BITS = $clog2(PLACES)
) (
    input  logic                  clk,
    input  logic                  rst,
    input  logic                  invalidate,
    input  logic                  check,
    input  logic [PLACE_BITS-1:0] place,
    input  logic [BLOCK_BITS-1:0] block,
    output logic                  misses  // the tile counts as present from the next cycle on
);
  logic [BLOCK_BITS-1:0] tags [PLACES]  /* verilator public_flat_rd */;
  logic [PLACES-1:0] valid  /* verilator public_flat_rd */;

  assign misses = check && !(valid[place] && tags[place] == block);

  always_ff @(posedge clk) begin
    if (misses) tags[place] <= block;
    if (rst || invalidate) valid <= '0;
    else if (misses) valid[place] <= 1'b1;
  end
endmodule
