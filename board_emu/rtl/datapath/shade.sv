// Local shading (shade() in datapath/shading-inl.h): an entry's colour, lit by the reflectance map. `entry`: of the
// segmentation LUT, from the lowest bit: red, green, blue 12, opacity 16, ambient, reflect, knee 8; the last 8 are
// not read.
module shade (
    input  logic        clk,
    input  logic        write,  // of the reflectance map
    input  logic [16:0] write_address,
    input  logic [7:0]  write_word,
    input  logic [75:0] entry,
    input  logic [47:0] gradient,
    output logic [35:0] colour
);
  localparam logic [31:0] SHORTEST = 32'((511 * 32 / 16) * (511 * 32 / 16));
  logic [16:0] reflected;
  logic [24:0] scaled;
  logic [17:0] lit, total, knee, base, highlight;
  logic [33:0] square;
  logic is_flat;
  reflectance map (.clk, .write, .write_address, .write_word, .gradient, .result(reflected));

  function automatic logic [33:0] squared(input logic signed [15:0] of);
    squared = 34'(32'(of) * 32'(of));
  endfunction
  assign square = squared(gradient[15:0]) + squared(gradient[31:16]) + squared(gradient[47:32]);
  assign is_flat = square < 34'(SHORTEST);
  assign scaled = 25'(entry[67:60]) * 25'(reflected) + 25'd64;
  assign lit = scaled[24:7];
  assign total = {2'd0, entry[59:52], 8'd0} + lit;
  assign knee = {2'd0, entry[75:68], 8'd0};
  assign base = total < knee ? total : knee;
  assign highlight = total - base;
  for (genvar c = 0; c < 3; c++) begin : gen_colour
    logic [11:0] mine;
    logic [31:0] sum;
    assign mine = entry[12*c +: 12];
    assign sum = 32'(mine) * 32'(base) + 32'd4095 * 32'(highlight) + 32'd16384;
    assign colour[12*c +: 12] = is_flat ? mine : sum[31:15] > 17'd4095 ? 12'd4095 : sum[26:15];
    logic unused;
    assign unused = ^sum[14:0];
  end
  logic unused;
  assign unused = ^{entry[51:36], scaled[6:0]};
endmodule
