// Tiles on their way from the cache to memory (asic/cache/write_queue.h, [P §3.4]), oldest first: sent ones,
// requested ones, and ones that wait until there are enough. A deposit changes up to eight tiles in a cycle. A tile
// that waits already absorbs the change; one that is no longer in the cache is fetched first. Entries have running
// numbers.
module write_queue #(
    parameter int unsigned TILES = 32,  // a power of two
    parameter int unsigned BLOCK_BITS = 9,
    parameter int unsigned TILE_BITS = 14,
    localparam int unsigned NUMBER_BITS = $clog2(TILES) + 1
) (
    input  logic                   clk,
    input  logic                   rst,
    input  logic                   ask_all,   // requests all that wait, also if they are few
    input  logic                   combines,
    input  logic [7:0]             put,       // only if has_room
    input  logic [BLOCK_BITS-1:0]  put_block,
    input  logic [8*TILE_BITS-1:0] put_tiles,
    input  logic [7:0]             in_cache,
    output logic                   has_room,  // for eight tiles, each fetched first
    output logic [7:0]             absorbed,
    output logic                   can_send,
    output logic [BLOCK_BITS-1:0]  next_block,
    output logic [TILE_BITS-1:0]   next_tile,
    output logic                   next_fetch,
    input  logic                   send,
    output logic [NUMBER_BITS-1:0] next_number,
    output logic [NUMBER_BITS-1:0] asked  // number of the first that is not requested
);
  localparam int unsigned PLACE_BITS = NUMBER_BITS - 1;
  localparam int unsigned ENTRY = 1 + BLOCK_BITS + TILE_BITS;
  logic [TILES*ENTRY-1:0] entries  /* verilator public_flat_rd */;
  logic [NUMBER_BITS-1:0] first  /* verilator public_flat_rd */;
  logic [NUMBER_BITS-1:0] next  /* verilator public_flat_rd */;
  logic [NUMBER_BITS-1:0] waiting  /* verilator public_flat_rd */;
  logic [NUMBER_BITS-1:0] last  /* verilator public_flat_rd */;

  logic [TILES*ENTRY-1:0] next_entries;
  logic [NUMBER_BITS-1:0] now_waiting, now_last, count;
  logic asks;

  // Tiles sent in an earlier cycle have left.
  assign has_room = NUMBER_BITS'(last - next) <= NUMBER_BITS'(TILES - 16);
  assign can_send = next != waiting;
  assign {next_fetch, next_block, next_tile} = entries[32'(next[PLACE_BITS-1:0])*ENTRY +: ENTRY];
  assign next_number = next;
  assign asked = waiting;
  assign count = last - waiting;
  assign asks = count != '0 && (ask_all || count >= NUMBER_BITS'(TILES / 2));
  assign now_waiting = asks ? last : waiting;

  always_comb begin
    logic [TILE_BITS-1:0] tile;
    logic [PLACE_BITS-1:0] of, fetch_at, write_at;
    next_entries = entries;
    now_last = last;
    fetch_at = '0;
    write_at = '0;
    absorbed = '0;
    for (int unsigned i = 0; i < 8; i++) begin
      tile = put_tiles[i*TILE_BITS +: TILE_BITS];
      for (int unsigned k = 0; k < TILES; k++) begin
        of = PLACE_BITS'(k) - now_waiting[PLACE_BITS-1:0];  // how many entries before place k wait
        if (put[i] && combines && {1'b0, of} < last - now_waiting &&
            entries[k*ENTRY +: ENTRY-1] == {put_block, tile}) absorbed[i] = 1'b1;
      end
      if (put[i] && !absorbed[i]) begin
        fetch_at = now_last[PLACE_BITS-1:0];
        if (!in_cache[i]) now_last = now_last + 1'b1;
        write_at = now_last[PLACE_BITS-1:0];
        now_last = now_last + 1'b1;
        for (int unsigned k = 0; k < TILES; k++) begin
          if (fetch_at == PLACE_BITS'(k)) next_entries[k*ENTRY +: ENTRY] = {1'b1, put_block, tile};
          if (write_at == PLACE_BITS'(k)) next_entries[k*ENTRY +: ENTRY] = {1'b0, put_block, tile};
        end
      end
    end
  end

  always_ff @(posedge clk) begin
    entries <= next_entries;
    first   <= rst ? '0 : next;
    next    <= rst ? '0 : next + NUMBER_BITS'(send);
    waiting <= rst ? '0 : now_waiting;
    last    <= rst ? '0 : now_last;
  end
endmodule
