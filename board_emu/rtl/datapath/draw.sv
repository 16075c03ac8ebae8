// Random numbers of a ray (datapath/random_stream.h): of its path segment, and of a place on it.
module draw (
    input  logic [3:0]  what,
    input  logic [95:0] position,
    input  logic [15:0] u,
    input  logic [15:0] v,
    input  logic [15:0] lifetime,
    input  logic [31:0] seed,
    output logic [63:0] of_segment,
    output logic [63:0] of_place
);
  logic [63:0] ray, low, here;
  mix64 mix_ray (.x({16'd0, lifetime, v, u}), .result(ray));
  mix64 mix_segment (.x(ray ^ {24'd0, seed, 4'd0, what}), .result(of_segment));
  mix64 mix_low (.x({position[63:32], position[31:0]}), .result(low));
  mix64 mix_here (.x(low ^ {32'd0, position[95:64]}), .result(here));
  mix64 mix_place (.x(here ^ of_segment), .result(of_place));
endmodule
