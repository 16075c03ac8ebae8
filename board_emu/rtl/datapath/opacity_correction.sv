// The power unit 1 - (1 - alpha)^e (datapath/opacity_correction.h): tables of log2 and 2^-x with 1024 linear segments
// each. A table is read at both ends of a segment.
module opacity_correction (
    input  logic        clk,
    input  logic        write_log2,
    input  logic        write_exp2,
    input  logic [10:0] write_address,  // 0 .. 1024
    input  logic [24:0] write_word,
    input  logic [27:0] full_scale,  // log2 of alpha's full scale, 8.24
    input  logic [15:0] alpha,
    input  logic [31:0] exponent,  // 16.16
    output logic [23:0] result
);
  logic [15:0] transparency, mantissa;
  logic [3:0] leading;
  logic [24:0] log_low, log_high;
  logic [14:0] rise;
  logic [20:0] risen;
  logic [27:0] logarithm;
  assign transparency = ~alpha;
  always_comb begin
    leading = '0;
    for (int unsigned i = 0; i < 16; i++) if (transparency[i]) leading = 4'(i);
  end
  assign mantissa = transparency << (5'd16 - 5'(leading));
  sram #(.WORDS(1025), .WIDTH(25)) log2_low (
      .clk, .write(write_log2), .write_address, .write_word, .address({1'b0, mantissa[15:6]}), .word(log_low));
  sram #(.WORDS(1025), .WIDTH(25)) log2_high (
      .clk, .write(write_log2), .write_address, .write_word, .address({1'b0, mantissa[15:6]} + 11'd1), .word(log_high));
  assign rise = 15'(log_high - log_low);
  assign risen = 21'(rise) * 21'(mantissa[5:0]) + 21'd32;
  assign logarithm = {leading, 24'd0} + 28'(log_low) + 28'(risen[20:6]);

  logic [27:0] depth;
  logic [59:0] product;
  logic [43:0] x;  // 20.24
  logic [24:0] exp_low, exp_high;
  logic [14:0] fall;
  logic [37:0] value;
  logic [5:0] shift;
  logic [38:0] rounded;
  assign depth = full_scale - logarithm;
  assign product = 60'(depth) * 60'(exponent) + 60'd32768;
  assign x = product[59:16];
  sram #(.WORDS(1025), .WIDTH(25)) exp2_low (
      .clk, .write(write_exp2), .write_address, .write_word, .address({1'b0, x[23:14]}), .word(exp_low));
  sram #(.WORDS(1025), .WIDTH(25)) exp2_high (
      .clk, .write(write_exp2), .write_address, .write_word, .address({1'b0, x[23:14]} + 11'd1), .word(exp_high));
  assign fall = 15'(exp_low - exp_high);
  assign value = {exp_low[23:0], 14'd0} - 38'(fall) * 38'(x[13:0]);
  assign shift = 6'(x[28:24]) + 6'd14;
  assign rounded = (39'(value) + (39'd1 << (shift - 6'd1))) >> shift;
  always_comb begin
    if (alpha == 16'hFFFF) result = 24'hFFFFFF;
    else if (x[43:24] > 20'd24) result = 24'hFFFFFF;
    else result = 24'hFFFFFF - rounded[23:0];
  end
  logic unused;
  assign unused = ^{product[15:0], risen[5:0], exp_low[24], rounded[38:24]};
endmodule
