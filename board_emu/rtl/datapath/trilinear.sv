// Seven interpolators for one channel [P §3.4]. Voxel i is at (i & 1, i >> 1 & 1, i >> 2).
module trilinear (
    input  logic [127:0] words,
    input  logic [41:0]  fraction,  // 14 bits an axis, x lowest
    output logic [15:0]  result
);
  logic [63:0] along_x;
  logic [31:0] along_y;
  for (genvar i = 0; i < 4; i++) begin : gen_x
    lerp interpolator (.a(words[32*i +: 16]), .b(words[32*i+16 +: 16]), .weight({fraction[13:0], 1'b0}),
                       .result(along_x[16*i +: 16]));
  end
  for (genvar i = 0; i < 2; i++) begin : gen_y
    lerp interpolator (.a(along_x[32*i +: 16]), .b(along_x[32*i+16 +: 16]), .weight({fraction[27:14], 1'b0}),
                       .result(along_y[16*i +: 16]));
  end
  lerp along_z (.a(along_y[15:0]), .b(along_y[31:16]), .weight({fraction[41:28], 1'b0}), .result(result));
endmodule
