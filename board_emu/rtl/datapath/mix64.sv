// The hash that mangles place and destination (proto/gicube/wire/mix64.h).
module mix64 (
    input  logic [63:0] x,
    output logic [63:0] result
);
  logic [63:0] one, two;
  assign one = (x ^ (x >> 30)) * 64'hBF58476D1CE4E5B9;
  assign two = (one ^ (one >> 27)) * 64'h94D049BB133111EB;
  assign result = two ^ (two >> 31);
endmodule
