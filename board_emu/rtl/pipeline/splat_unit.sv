// The unit that adds deposits to the irradiance words (cycle/splat_unit.h, [P §3.4]): it takes the cache's banks for
// two cycles, and sends the deposit's carriers one by one.
module splat_unit (
    input  logic       clk,
    input  logic       rst,
    input  logic       begins,  // only if not busy
    input  logic       has_tiles,
    input  logic [3:0] carriers,
    input  logic       sent_carrier,
    output logic       takes_cache,  // from the cycle of the beginning on
    output logic       has_carrier,
    output logic [2:0] carrier,  // number of the one to be sent
    output logic       busy          // after that carrier
);
  logic one_cycle_left  /* verilator public_flat_rd */;
  logic [3:0] next  /* verilator public_flat_rd */;
  logic [3:0] count  /* verilator public_flat_rd */;

  assign takes_cache = one_cycle_left || (begins && has_tiles);
  assign has_carrier = next < count;
  assign carrier = next[2:0];
  assign busy = one_cycle_left || next + 4'(sent_carrier) < count;

  always_ff @(posedge clk) begin
    if (rst) begin
      one_cycle_left <= '0;
      next <= '0;
      count <= '0;
    end else if (begins) begin
      one_cycle_left <= has_tiles;  // this cycle is the first of the two
      next <= '0;
      count <= carriers;
    end else begin
      one_cycle_left <= 1'b0;
      next <= next + 4'(sent_carrier);
    end
  end
endmodule
