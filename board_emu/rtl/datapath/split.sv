// Splits a deposit's whole units among the eight voxels of a cell by systematic rounding (datapath/trilinear_splat.h,
// [P §2.2]).
module split (
    input  logic [31:0]  units,
    input  logic [41:0]  fraction,  // 14 bits an axis, x lowest
    input  logic [27:0]  offset,    // decides the roundings
    output logic [255:0] shares
);
  always_comb begin
    logic [14:0] x, y, z;
    logic [42:0] sum;  // of the weights; 2^42 after the last
    logic [32:0] given, earlier;
    sum = '0;
    earlier = '0;
    for (int unsigned i = 0; i < 8; i++) begin
      x = i[0] ? {1'b0, fraction[13:0]} : 15'd16384 - {1'b0, fraction[13:0]};
      y = i[1] ? {1'b0, fraction[27:14]} : 15'd16384 - {1'b0, fraction[27:14]};
      z = i[2] ? {1'b0, fraction[41:28]} : 15'd16384 - {1'b0, fraction[41:28]};
      sum = sum + 43'(x) * 43'(y) * 43'(z);
      given = 33'((61'(units) * 61'(sum[42:14]) + 61'(offset)) >> 28);
      shares[32*i +: 32] = 32'(given - earlier);
      earlier = given;
    end
  end
endmodule
