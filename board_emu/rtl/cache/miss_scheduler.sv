// The miss scheduler [P §3.3, §3.4]: a processor's reads and writes of memory (MemoryClient in cycle/memory_port.h),
// in the order of their requests, a read before a write of the same cycle. A read keeps the number of writes that
// were requested before it.
module miss_scheduler #(
    parameter int unsigned PACKETS = 32,
    parameter int unsigned TILES = 32,
    parameter int unsigned BLOCK_BITS = 9,
    parameter int unsigned TILE_BITS = 14
) (
    input  logic                   clk,
    input  logic                   rst,
    input  logic [3:0]             ask,
    input  logic [BLOCK_BITS-1:0]  ask_block,
    input  logic [8*TILE_BITS-1:0] ask_tiles,
    output logic                   has_room,
    input  logic                   arrives,
    output logic                   has_arrived,
    input  logic                   take,
    input  logic                   ask_all,
    input  logic                   combines,
    input  logic [7:0]             put,
    input  logic [BLOCK_BITS-1:0]  put_block,
    input  logic [8*TILE_BITS-1:0] put_tiles,
    input  logic [7:0]             in_cache,
    output logic                   put_has_room,
    output logic [7:0]             absorbed,
    // To the memory.
    output logic                   can_send,
    output logic                   is_write,  // an entry of the write queue
    output logic                   reads,     // a read, also one that precedes a write
    output logic [BLOCK_BITS-1:0]  block,
    output logic [TILE_BITS-1:0]   tile,
    input  logic                   send
);
  localparam int unsigned NUMBER_BITS = $clog2(TILES) + 1;
  logic can_read, can_write, fetch;
  logic [BLOCK_BITS-1:0] read_block, write_block;
  logic [TILE_BITS-1:0] read_tile, write_tile;
  logic [NUMBER_BITS-1:0] stamp, number, asked;

  miss_queue #(.PACKETS(PACKETS), .BLOCK_BITS(BLOCK_BITS), .TILE_BITS(TILE_BITS), .STAMP_BITS(NUMBER_BITS)) misses (
      .clk, .rst, .ask, .ask_block, .ask_tiles, .ask_stamp(asked), .has_room, .can_send(can_read),
      .next_block(read_block), .next_tile(read_tile), .next_stamp(stamp), .send(send && !is_write), .arrives,
      .has_arrived, .take);
  write_queue #(.TILES(TILES), .BLOCK_BITS(BLOCK_BITS), .TILE_BITS(TILE_BITS)) writes (
      .clk, .rst, .ask_all, .combines, .put, .put_block, .put_tiles, .in_cache, .has_room(put_has_room), .absorbed,
      .can_send(can_write), .next_block(write_block), .next_tile(write_tile), .next_fetch(fetch),
      .send(send && is_write), .next_number(number), .asked);

  assign can_send = can_read || can_write;
  assign is_write = can_write && (!can_read || number != stamp);
  assign reads = is_write ? fetch : can_read;
  assign block = is_write ? write_block : read_block;
  assign tile = is_write ? write_tile : read_tile;
endmodule
