// Front-to-back compositing (datapath/composite.h), and the sorter's weight of the ray afterwards, its importance [P
// §2.1].
module composite (
    input  logic [35:0] ray_colour,
    input  logic [23:0] ray_opacity,
    input  logic [35:0] colour,
    input  logic [23:0] alpha,
    output logic [35:0] next_colour,
    output logic [23:0] next_opacity,
    output logic [11:0] contribution
);
  // The product of two words whose full scale is one, 24 bits the second.
  function automatic logic [23:0] product(input logic [23:0] a, input logic [23:0] b);
    logic [48:0] sum;
    sum = 49'(a) * 49'(b) + 49'd8388608;
    product = 24'((sum + (sum >> 24)) >> 24);
  endfunction

  logic [23:0] weight, left;
  assign weight = product(24'hFFFFFF - ray_opacity, alpha);
  assign next_opacity = ray_opacity + weight;
  assign left = 24'hFFFFFF - next_opacity;
  assign contribution = left[23:12];
  for (genvar c = 0; c < 3; c++) begin : gen_colour
    logic [12:0] sum;
    assign sum = 13'(ray_colour[12*c +: 12]) + 13'(product(24'(colour[12*c +: 12]), weight));
    assign next_colour[12*c +: 12] = sum > 13'd4095 ? 12'd4095 : sum[11:0];
  end
  logic unused;
  assign unused = ^left[11:0];
endmodule
