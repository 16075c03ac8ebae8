// A linear interpolator (datapath/resample.h): a + round((b - a) weight), weight in 0.15. The difference fits 16 bits.
module lerp (
    input  logic signed [15:0] a,
    input  logic signed [15:0] b,
    input  logic [14:0]        weight,
    output logic signed [15:0] result
);
  logic signed [15:0] difference;
  logic signed [31:0] product;
  assign difference = b - a;
  assign product = 32'(difference) * $signed(32'(weight)) + 32'sd16384;
  assign result = a + 16'(product >>> 15);
endmodule
