// The line of rays through the pipeline (cycle/stages.h and Processor::enter_compute()). A counter holds a sample
// until its packets have come [P §3.3]; it goes on in the cycle of the last, by the bypass.
module stages #(
    parameter int unsigned PREFETCH = 16,
    parameter int unsigned COMPUTE = 16,
    parameter int unsigned ENTRY = 64
) (
    input  logic             clk,
    input  logic             rst,
    input  logic             enter,
    input  logic [ENTRY-1:0] entry,
    input  logic [3:0]       entry_packets,
    output logic             can_enter,
    input  logic             cache_taken,  // the banks are busy with a deposit
    input  logic             has_arrived,  // the oldest packet can be written
    output logic             takes_packet,
    output logic             starts,  // a sample enters the compute stages
    output logic             has_last,
    output logic [ENTRY-1:0] last,
    input  logic             stall    // `last` can't leave
);
  logic has_head, ready;
  logic [ENTRY-1:0] head;
  logic [3:0] head_packets;

  assign ready = has_head && !stall && !cache_taken;
  assign takes_packet = ready && head_packets != 4'd0 && has_arrived;
  assign starts = ready && (head_packets == 4'd0 || (head_packets == 4'd1 && has_arrived));

  prefetch_line #(.STAGES(PREFETCH), .ENTRY(ENTRY)) prefetch (
      .clk, .rst, .enter, .entry, .entry_packets, .can_enter, .has_head, .head, .head_packets,
      .take_packet(takes_packet), .leave(starts));
  compute_line #(.STAGES(COMPUTE), .ENTRY(ENTRY)) compute (
      .clk, .rst, .move(!stall), .enter(starts), .entry(head), .has_last, .last);
endmodule
