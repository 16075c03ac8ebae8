// round(minor / major * 127 * 128) for |minor| <= major, with the roundings of IEEE single precision, to nearest and
// ties to even, after the quotient, the product and at the end (to_texel() in datapath/shading-inl.h): an integer
// divider gives the quotient's 24 bits.
module float_ratio (
    input  logic signed [16:0] minor,
    input  logic [16:0]        major,  // not 0
    output logic signed [15:0] result
);
  function automatic logic [4:0] leading(input logic [16:0] of);
    leading = '0;
    for (int unsigned i = 0; i < 17; i++) if (of[i]) leading = 5'(i);
  endfunction

  logic [16:0] size, aligned, rest;
  logic [4:0] gap;
  logic [5:0] shift;
  logic [40:0] dividend, quotient;
  logic [24:0] ratio;  // 24 bits, times 2^-shift; 2^24 after rounding up
  logic [31:0] product, dropped;
  logic [24:0] rounded;
  logic [3:0] drop;
  logic [5:0] right;
  logic [24:0] whole, below;

  assign size = minor < 0 ? 17'(-minor) : 17'(minor);
  assign gap = leading(major) - leading(size);
  assign aligned = size << gap;
  assign shift = 6'd23 + 6'(gap) + 6'(aligned < major);
  assign dividend = 41'(size) << shift;
  assign quotient = dividend / 41'(major);
  assign rest = 17'(dividend - quotient * 41'(major));
  assign ratio = 25'(quotient) +
      25'({rest, 1'b0} > {1'b0, major} || ({rest, 1'b0} == {1'b0, major} && quotient[0]));

  assign product = 32'(ratio) * 32'd127;
  assign drop = product[31] ? 4'd8 : product[30] ? 4'd7 : 4'd6;
  assign dropped = product >> drop;
  always_comb begin
    logic [31:0] lost, half;
    lost = product - (dropped << drop);
    half = 32'd1 << (drop - 4'd1);
    rounded = 25'(dropped) + 25'(lost > half || (lost == half && dropped[0]));
  end
  assign right = shift - 6'd7 - 6'(drop);
  assign whole = right > 6'd25 ? '0 : rounded >> right;
  assign below = right > 6'd25 ? '0 : rounded - (whole << right);
  always_comb begin
    logic [24:0] half;
    logic [15:0] nearest;
    half = 25'd1 << (right - 6'd1);
    nearest = 16'(whole) + 16'(right <= 6'd25 && (below > half || (below == half && whole[0])));
    result = size == '0 ? 16'sd0 : minor < 0 ? -$signed(nearest) : $signed(nearest);
  end
endmodule
