// The compute stages (cycle/stages.h, [P §3.4]), which all move or all stall.
module compute_line #(
    parameter int unsigned STAGES = 16,
    parameter int unsigned ENTRY = 64
) (
    input  logic             clk,
    input  logic             rst,
    input  logic             move,
    input  logic             enter,
    input  logic [ENTRY-1:0] entry,
    output logic             has_last,
    output logic [ENTRY-1:0] last
);
  logic [STAGES*ENTRY-1:0] entries  /* verilator public_flat_rd */;
  logic [STAGES-1:0] valid  /* verilator public_flat_rd */;

  assign has_last = valid[STAGES-1];
  assign last = entries[(STAGES-1)*ENTRY +: ENTRY];

  always_ff @(posedge clk) begin
    if (move) entries <= {entries[(STAGES-1)*ENTRY-1:0], entry};
    if (rst) valid <= '0;
    else if (move) valid <= {valid[STAGES-2:0], enter};
  end
endmodule
