// Tags of the eight-way interleaved volume cache (asic/cache/volume_cache.h, [P §2.1, §3.3]): direct mapped by the
// place in the block, one tag for each tile of 2 x 2 x 1 voxels. A neighbourhood's tiles lie in different banks, by
// the lowest bits of their places along x, y and z, so all are checked in one cycle.
module volume_cache #(
    parameter int unsigned BLOCK_VOXELS = 32,
    parameter int unsigned BLOCK_BITS = 9,
    localparam int unsigned TILES_X = BLOCK_VOXELS / 2 + 1,
    localparam int unsigned SLICES = BLOCK_VOXELS + 1,
    localparam int unsigned VOXEL_BITS = $clog2(BLOCK_VOXELS),
    localparam int unsigned TILE_BITS = $clog2(TILES_X * TILES_X * SLICES)
) (
    input  logic                    clk,
    input  logic                    rst,
    input  logic                    invalidate,
    input  logic                    check,
    input  logic [BLOCK_BITS-1:0]   block,
    input  logic [3*VOXEL_BITS-1:0] voxel,  // x lowest
    output logic [3:0]              count,  // missing tiles
    output logic [8*TILE_BITS-1:0]  tiles
);
  localparam int unsigned ACROSS = (TILES_X + 1) / 2;
  localparam int unsigned DEEP = (SLICES + 1) / 2;
  localparam int unsigned PLACES = ACROSS * ACROSS * DEEP;
  localparam int unsigned PLACE_BITS = $clog2(PLACES);

  logic [VOXEL_BITS:0] x, y, z;  // of the first tile
  logic two_x, two_y;
  logic [7:0] bank_misses, misses;  // by bank; by the tile's place in the neighbourhood
  assign two_x = voxel[0];
  assign two_y = voxel[VOXEL_BITS];
  assign x = (VOXEL_BITS+1)'(voxel[VOXEL_BITS-1:1]);
  assign y = (VOXEL_BITS+1)'(voxel[2*VOXEL_BITS-1:VOXEL_BITS+1]);
  assign z = (VOXEL_BITS+1)'(voxel[3*VOXEL_BITS-1:2*VOXEL_BITS]);

  for (genvar b = 0; b < 8; b++) begin : gen_bank
    localparam logic [2:0] BANK = 3'(b);
    logic [2:0] offset;
    logic [VOXEL_BITS:0] bank_x, bank_y, bank_z;
    assign offset = BANK ^ {z[0], y[0], x[0]};
    assign bank_x = (x + (VOXEL_BITS+1)'(offset[0])) >> 1;
    assign bank_y = (y + (VOXEL_BITS+1)'(offset[1])) >> 1;
    assign bank_z = (z + (VOXEL_BITS+1)'(offset[2])) >> 1;
    tag_bank #(.PLACES(PLACES), .BLOCK_BITS(BLOCK_BITS)) bank (
        .clk, .rst, .invalidate, .check(check && (two_x || !offset[0]) && (two_y || !offset[1])),
        .place(PLACE_BITS'((32'(bank_z) * ACROSS + 32'(bank_y)) * ACROSS + 32'(bank_x))), .block,
        .misses(bank_misses[b]));
  end

  always_comb begin
    logic [2:0] bank;
    count = '0;
    tiles = '0;
    for (int unsigned o = 0; o < 8; o++) begin
      bank = 3'(o) ^ {z[0], y[0], x[0]};
      misses[o] = bank_misses[bank];
      if (misses[o]) begin
        tiles[32'(count[2:0])*TILE_BITS +: TILE_BITS] =
            TILE_BITS'(((32'(z) + 32'(o >> 2)) * TILES_X + 32'(y) + 32'(o >> 1 & 1)) * TILES_X + 32'(x) + 32'(o & 1));
        count = count + 4'd1;
      end
    end
  end
endmodule
