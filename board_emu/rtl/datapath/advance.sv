// Advancing and empty-space skipping (datapath/advance.h, [P §2.1]): a sample's ray makes one step; in an empty block
// it makes the least number of whole steps that leave the block [low, low + 2^EDGE_BITS).
module advance #(
    parameter int unsigned EDGE_BITS = 19  // of a block's edge in position units
) (
    input  logic        skips,
    input  logic [95:0] position,  // 14 fraction bits, x lowest
    input  logic [95:0] step,
    input  logic [95:0] low,
    input  logic [95:0] extent,
    output logic [31:0] steps,
    output logic [95:0] next,
    output logic        is_inside
);
  logic [95:0] least;  // steps by which an axis leaves the block
  logic [2:0] in;
  logic [31:0] fewest;
  for (genvar axis = 0; axis < 3; axis++) begin : gen_axis
    logic signed [31:0] at, by, to, offset;
    logic [31:0] size, gap;
    assign at = position[32*axis +: 32];
    assign by = step[32*axis +: 32];
    assign offset = at - $signed(low[32*axis +: 32]);
    assign size = by < 0 ? -by : by;
    // Rounded up: to the upper face, or one unit beyond the lower face.
    assign gap = by < 0 ? offset : (32'd1 << EDGE_BITS) - offset - 32'd1;
    assign least[32*axis +: 32] = by == 0 ? 32'd1 << EDGE_BITS : gap / size + 32'd1;
    assign to = at + by * $signed(steps);
    assign next[32*axis +: 32] = to;
    assign in[axis] = to >= 0 && to <= $signed(extent[32*axis +: 32]);
  end
  always_comb begin
    fewest = 32'd1 << EDGE_BITS;
    for (int unsigned axis = 0; axis < 3; axis++) if (least[32*axis +: 32] < fewest) fewest = least[32*axis +: 32];
  end
  assign steps = skips ? fewest : 32'd1;
  assign is_inside = &in;
endmodule
