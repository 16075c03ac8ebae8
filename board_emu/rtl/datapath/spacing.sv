// The spacing unit (datapath/jitter.h, jitter_step() in datapath/ray_step.h, [P §3.4]): the random factor of the
// distance to the next sample, the step, and the exponent of opacity correction.
module spacing (
    input  logic         clk,
    input  logic         write,  // of the table of factors, 16 fraction bits
    input  logic [7:0]   write_address,
    input  logic [16:0]  write_word,
    input  logic         jitters,
    input  logic [95:0]  position,
    input  logic [15:0]  u,
    input  logic [15:0]  v,
    input  logic [47:0]  direction,
    input  logic [31:0]  frame_step,    // 16.16 voxels
    input  logic [31:0]  voxel_length,  // 16.16
    output logic [95:0]  step,
    output logic [31:0]  exponent
);
  logic [63:0] low, high, mixed_low, mixed;
  logic [16:0] factor;
  logic [48:0] jittered;
  logic [31:0] distance;
  logic [63:0] scaled;
  assign low = 64'(position[31:0]) | 64'(position[63:32]) << 24;
  assign high = 64'(position[95:64]) | 64'(u) << 24 | 64'(v) << 40;
  mix64 first (.x(low), .result(mixed_low));
  mix64 second (.x(mixed_low ^ high), .result(mixed));
  sram #(.WORDS(256), .WIDTH(17)) factors (
      .clk, .write, .write_address, .write_word, .address(mixed[7:0]), .word(factor));
  assign jittered = 49'(frame_step) * 49'(factor) + 49'd32768;
  assign distance = jitters ? jittered[47:16] : frame_step;
  assign scaled = 64'(distance) * 64'(voxel_length) + 64'd32768;
  assign exponent = scaled[47:16];
  for (genvar axis = 0; axis < 3; axis++) begin : gen_axis
    step_vector vector (.direction(direction[16*axis +: 16]), .length(distance), .step(step[32*axis +: 32]));
  end
  logic unused;
  assign unused = ^{mixed[63:8], jittered[48], jittered[15:0], scaled[63:48], scaled[15:0]};
endmodule
