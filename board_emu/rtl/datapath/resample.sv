// The resampling unit (datapath/resample.h, [P §3.3, §3.4]): eight gradient LUTs, and interpolators for density,
// gradient and irradiance. A voxel has 36 bits, from the lowest: density 12, gradient code 11, tag 2, irradiance 11.
// The tag is the nearest voxel's.
module resample (
    input  logic         clk,
    input  logic         write,  // of the gradient LUTs
    input  logic [10:0]  write_address,
    input  logic [29:0]  write_word,
    input  logic [287:0] voxels,
    input  logic [41:0]  fraction,
    output logic [15:0]  density,     // 12.3
    output logic [47:0]  gradient,    // 511 * 32 = one; x lowest
    output logic [15:0]  irradiance,  // 11.4
    output logic [1:0]   tag
);
  logic [127:0] densities, irradiances;
  logic [383:0] gradients;
  logic [15:0] tags;
  for (genvar i = 0; i < 8; i++) begin : gen_voxel
    logic [35:0] voxel;
    logic [29:0] vector;
    assign voxel = voxels[36*i +: 36];
    sram #(.WORDS(2048), .WIDTH(30)) lut (.clk, .write, .write_address, .write_word,
                                        .address(voxel[22:12]), .word(vector));
    assign densities[16*i +: 16] = {1'b0, voxel[11:0], 3'd0};
    assign irradiances[16*i +: 16] = {1'b0, voxel[35:25], 4'd0};
    assign tags[2*i +: 2] = voxel[24:23];
    for (genvar axis = 0; axis < 3; axis++) begin : gen_axis
      assign gradients[128*axis+16*i +: 16] = {vector[10*axis+9], vector[10*axis +: 10], 5'd0};
    end
  end
  assign tag = tags[{fraction[41], fraction[27], fraction[13], 1'b0} +: 2];
  trilinear of_density (.words(densities), .fraction, .result(density));
  trilinear of_irradiance (.words(irradiances), .fraction, .result(irradiance));
  for (genvar axis = 0; axis < 3; axis++) begin : gen_gradient
    trilinear component (.words(gradients[128*axis +: 128]), .fraction, .result(gradient[16*axis +: 16]));
  end
endmodule
