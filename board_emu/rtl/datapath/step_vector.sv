// One axis of a step (datapath/advance.h): direction (1.14) times length (16.16 voxels), rounded to 14 fraction bits.
module step_vector (
    input  logic signed [15:0] direction,
    input  logic [31:0]        length,
    output logic signed [31:0] step
);
  logic signed [48:0] product;
  assign product = 49'(direction) * $signed({17'd0, length}) + 49'sd32768;
  assign step = 32'(product >>> 16);
endmodule
