// Packets that were requested and not yet written into the cache (asic/cache/miss_queue.h, [P §3.3]), oldest first:
// some arrived, some sent, the rest to be sent. Up to eight are requested in a cycle. `stamp` orders requests against
// writes (miss_scheduler.sv).
module miss_queue #(
    parameter int unsigned PACKETS = 32,
    parameter int unsigned BLOCK_BITS = 9,
    parameter int unsigned TILE_BITS = 14,
    parameter int unsigned STAMP_BITS = 6,
    localparam int unsigned PLACE_BITS = $clog2(PACKETS),
    localparam int unsigned COUNT_BITS = $clog2(PACKETS + 1)
) (
    input  logic                   clk,
    input  logic                   rst,
    input  logic [3:0]             ask,  // number of tiles; only if has_room
    input  logic [BLOCK_BITS-1:0]  ask_block,
    input  logic [8*TILE_BITS-1:0] ask_tiles,
    input  logic [STAMP_BITS-1:0]  ask_stamp,
    output logic                   has_room,  // for eight
    output logic                   can_send,
    output logic [BLOCK_BITS-1:0]  next_block,
    output logic [TILE_BITS-1:0]   next_tile,
    output logic [STAMP_BITS-1:0]  next_stamp,
    input  logic                   send,
    input  logic                   arrives,  // the oldest sent packet that has not arrived
    output logic                   has_arrived,
    input  logic                   take
);
  localparam int unsigned ENTRY = BLOCK_BITS + TILE_BITS + STAMP_BITS;
  logic [ENTRY-1:0] entries [PACKETS]  /* verilator public_flat_rd */;
  logic [PLACE_BITS-1:0] head  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] size  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] sent  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] arrived  /* verilator public_flat_rd */;

  function automatic logic [PLACE_BITS-1:0] place(input logic [PLACE_BITS-1:0] from, input logic [COUNT_BITS-1:0] by);
    logic [COUNT_BITS:0] sum;
    sum = (COUNT_BITS+1)'(from) + (COUNT_BITS+1)'(by);
    place = PLACE_BITS'(sum >= (COUNT_BITS+1)'(PACKETS) ? sum - (COUNT_BITS+1)'(PACKETS) : sum);
  endfunction

  assign has_room = size <= COUNT_BITS'(PACKETS - 8);
  assign can_send = sent != size;
  assign {next_stamp, next_block, next_tile} = entries[place(head, sent)];
  assign has_arrived = arrived != '0 || arrives;

  always_ff @(posedge clk) begin
    for (int unsigned i = 0; i < 8; i++) begin
      if (4'(i) < ask) begin
        entries[place(head, size + COUNT_BITS'(i))] <= {ask_stamp, ask_block, ask_tiles[i*TILE_BITS +: TILE_BITS]};
      end
    end
    if (rst) begin
      head <= '0;
      size <= '0;
      sent <= '0;
      arrived <= '0;
    end else begin
      if (take) head <= place(head, COUNT_BITS'(1));
      size <= size + COUNT_BITS'(ask) - COUNT_BITS'(take);
      sent <= sent + COUNT_BITS'(send) - COUNT_BITS'(take);
      arrived <= arrived + COUNT_BITS'(arrives) - COUNT_BITS'(take);
    end
  end
endmodule
