// The tree of merging nodes from the processors to the DSP (asic/raybus/merge_tree.h, [P §3.6]). LEAVES is a power of
// two. Streams are numbered like a heap: 1 is the output, node n merges streams 2n and 2n + 1, leaf i is stream
// LEAVES + i.
module merge_tree #(
    parameter int unsigned LEAVES = 8,
    parameter int unsigned TOKEN = 64
) (
    input  logic                    clk,
    input  logic                    rst,
    input  logic [LEAVES-1:0]       comes,
    input  logic [LEAVES*TOKEN-1:0] leaves,
    output logic [LEAVES-1:0]       takes,
    input  logic                    ready,
    output logic                    push,
    output logic [TOKEN-1:0]        token,
    output logic                    waits  // the root has a ray, and the output is full
);
  logic [2*LEAVES-1:2] has, pops;
  logic [2*LEAVES*TOKEN-1:2*TOKEN] items;

  assign has[2*LEAVES-1:LEAVES] = comes;
  assign items[2*LEAVES*TOKEN-1:LEAVES*TOKEN] = leaves;
  assign takes = pops[2*LEAVES-1:LEAVES];
  assign waits = (|has[3:2]) && !ready;

  for (genvar n = 1; n < LEAVES; n++) begin : gen_node
    logic node_ready, node_push;
    logic [TOKEN-1:0] node_token;
    merge_node #(.TOKEN(TOKEN)) merge (
        .clk, .rst, .comes(has[2*n +: 2]), .token_0(items[2*n*TOKEN +: TOKEN]),
        .token_1(items[(2*n+1)*TOKEN +: TOKEN]), .takes(pops[2*n +: 2]), .ready(node_ready), .push(node_push),
        .token(node_token));
    if (n == 1) begin : gen_root
      assign node_ready = ready;
      assign push = node_push;
      assign token = node_token;
    end else begin : gen_between
      logic [1:0] size;
      assign has[n] = size != 2'd0;
      assign node_ready = size < 2'd2;
      fifo #(.WIDTH(TOKEN), .PLACES(2)) between (
          .clk, .rst, .push(node_push), .push_item(node_token), .pop(pops[n]), .front(items[n*TOKEN +: TOKEN]), .size);
    end
  end
endmodule
