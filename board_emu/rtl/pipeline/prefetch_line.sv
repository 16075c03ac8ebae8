// The prefetch stages (cycle/stages.h, [P §3.3]): a sample takes at least STAGES cycles, waits at the end for its
// packets, and those behind it close up.
module prefetch_line #(
    parameter int unsigned STAGES = 16,
    parameter int unsigned ENTRY = 64
) (
    input  logic             clk,
    input  logic             rst,
    input  logic             enter,  // only if can_enter
    input  logic [ENTRY-1:0] entry,
    input  logic [3:0]       entry_packets,
    output logic             can_enter,
    output logic             has_head,
    output logic [ENTRY-1:0] head,
    output logic [3:0]       head_packets,
    input  logic             take_packet,
    input  logic             leave
);
  logic [STAGES*ENTRY-1:0] entries  /* verilator public_flat_rd */;  // the last stage is the end
  logic [STAGES*4-1:0] packets  /* verilator public_flat_rd */;
  logic [STAGES-1:0] valid  /* verilator public_flat_rd */;
  logic [STAGES-1:0] moves;  // into the next stage, or out

  assign has_head = valid[STAGES-1];
  assign head = entries[(STAGES-1)*ENTRY +: ENTRY];
  assign head_packets = packets[(STAGES-1)*4 +: 4];
  assign can_enter = !(&valid) || leave;

  // A sample moves if some stage before it becomes free.
  for (genvar s = 0; s < STAGES; s++) begin : gen_stage
    if (s + 1 == STAGES) begin : gen_end
      assign moves[s] = leave;
    end else begin : gen_before
      assign moves[s] = valid[s] && (!(&valid[STAGES-1:s+1]) || leave);
    end
    always_ff @(posedge clk) begin
      if (s == 0 ? enter : moves[s == 0 ? 0 : s-1]) begin
        entries[s*ENTRY +: ENTRY] <= s == 0 ? entry : entries[(s == 0 ? 0 : s-1)*ENTRY +: ENTRY];
        packets[s*4 +: 4] <= s == 0 ? entry_packets : packets[(s == 0 ? 0 : s-1)*4 +: 4];
        valid[s] <= !rst;
      end else begin
        if (s + 1 == STAGES && take_packet) packets[s*4 +: 4] <= packets[s*4 +: 4] - 4'd1;
        if (rst || moves[s]) valid[s] <= 1'b0;
      end
    end
  end
endmodule
