// The reflectance map (datapath/shading-inl.h, [P §3.4]): the texels round the normal opposite to a gradient, and
// their bilinear interpolation, 15 fraction bits. The map lies in four banks, by the lowest bits of column and row,
// so that its four texels are read at once.
module reflectance (
    input  logic        clk,
    input  logic        write,
    input  logic [16:0] write_address,  // face, row, column
    input  logic [7:0]  write_word,
    input  logic [47:0] gradient,
    output logic [16:0] result
);
  logic signed [16:0] normal_x, normal_y, normal_z;
  logic [16:0] size_x, size_y, size_z, larger, largest;
  logic y_larger, z_major;
  logic signed [16:0] b, c;
  logic negative;
  logic [2:0] face;
  assign normal_x = 17'sd0 - 17'($signed(gradient[15:0]));
  assign normal_y = 17'sd0 - 17'($signed(gradient[31:16]));
  assign normal_z = 17'sd0 - 17'($signed(gradient[47:32]));
  assign size_x = normal_x < 0 ? 17'(-normal_x) : 17'(normal_x);
  assign size_y = normal_y < 0 ? 17'(-normal_y) : 17'(normal_y);
  assign size_z = normal_z < 0 ? 17'(-normal_z) : 17'(normal_z);
  assign y_larger = size_y > size_x;
  assign larger = y_larger ? size_y : size_x;
  assign z_major = size_z > larger;
  assign largest = z_major ? size_z : larger;
  assign b = z_major || y_larger ? normal_x : normal_y;
  assign c = z_major ? normal_y : normal_z;
  assign negative = z_major ? normal_z < 0 : y_larger ? normal_y < 0 : normal_x < 0;
  assign face = (z_major ? 3'd4 : y_larger ? 3'd2 : 3'd0) + 3'(negative);

  logic signed [15:0] ratio_b, ratio_c;
  logic [15:0] column, row;
  logic [6:0] i, j;
  logic [8:0] s, t;
  float_ratio to_column (.minor(b), .major(largest == '0 ? 17'd1 : largest), .result(ratio_b));
  float_ratio to_row (.minor(c), .major(largest == '0 ? 17'd1 : largest), .result(ratio_c));
  assign column = 16'(ratio_b + 16'sd16256);
  assign row = 16'(ratio_c + 16'sd16256);
  assign i = column[14:8] > 7'd126 ? 7'd126 : column[14:8];
  assign j = row[14:8] > 7'd126 ? 7'd126 : row[14:8];
  assign s = 9'(column - {1'b0, i, 8'd0});
  assign t = 9'(row - {1'b0, j, 8'd0});

  logic [31:0] texels;  // by bank
  for (genvar bank = 0; bank < 4; bank++) begin : gen_bank
    localparam logic [1:0] NUMBER = 2'(bank);
    logic [6:0] across, down;
    assign across = i + {6'd0, i[0] ^ NUMBER[0]};
    assign down = j + {6'd0, j[0] ^ NUMBER[1]};
    sram #(.WORDS(6 * 64 * 64), .WIDTH(8)) map (
        .clk, .write(write && write_address[0] == NUMBER[0] && write_address[7] == NUMBER[1]),
        .write_address({write_address[16:8], write_address[6:1]}), .write_word,
        .address({face, down[6:1], across[6:1]}), .word(texels[8*bank +: 8]));
    logic unused;
    assign unused = across[0] ^ down[0];
  end

  function automatic logic [16:0] mixed(input logic [7:0] one, input logic [7:0] two, input logic [8:0] weight);
    mixed = 17'(one) * (17'd256 - 17'(weight)) + 17'(two) * 17'(weight);
  endfunction
  logic [16:0] top, bottom;
  logic [25:0] sum;
  assign top = mixed(texels[{j[0], i[0], 3'd0} +: 8], texels[{j[0], ~i[0], 3'd0} +: 8], s);
  assign bottom = mixed(texels[{~j[0], i[0], 3'd0} +: 8], texels[{~j[0], ~i[0], 3'd0} +: 8], s);
  assign sum = 26'(top) * (26'd256 - 26'(t)) + 26'(bottom) * 26'(t) + 26'd128;
  assign result = sum[24:8];
  logic unused;
  assign unused = ^{column[15], row[15], sum[25], sum[7:0]};
endmodule
