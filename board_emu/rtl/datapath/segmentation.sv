// The segmentation LUT [P §3.4]: an entry of 84 bits by density and tag (proto/gicube/wire/lut.h).
module segmentation (
    input  logic        clk,
    input  logic        write,
    input  logic [13:0] write_address,
    input  logic [83:0] write_word,
    input  logic [15:0] density,  // 12.3, not negative
    input  logic [1:0]  tag,
    output logic [83:0] entry
);
  logic [15:0] rounded;
  assign rounded = (density + 16'd4) >> 3;
  sram #(.WORDS(16384), .WIDTH(84)) lut (
      .clk, .write, .write_address, .write_word, .address({tag, rounded[11:0]}), .word(entry));
  logic unused;
  assign unused = |rounded[15:12];
endmodule
