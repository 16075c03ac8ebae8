// A node of the merge tree: one ray a cycle, from its two inputs in turns.
module merge_node #(
    parameter int unsigned TOKEN = 64
) (
    input  logic             clk,
    input  logic             rst,
    input  logic [1:0]       comes,
    input  logic [TOKEN-1:0] token_0,
    input  logic [TOKEN-1:0] token_1,
    output logic [1:0]       takes,
    input  logic             ready,
    output logic             push,
    output logic [TOKEN-1:0] token
);
  logic turn  /* verilator public_flat_rd */;
  logic from;

  assign from = (&comes) ? turn : comes[1];
  assign push = (|comes) && ready;
  assign takes = {push && from, push && !from};
  assign token = from ? token_1 : token_0;

  always_ff @(posedge clk) begin
    if (rst) turn <= 1'b0;
    else if (push) turn <= !from;
  end
endmodule
