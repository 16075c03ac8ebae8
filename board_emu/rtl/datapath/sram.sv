// A table in SRAM with one port to write and one to read.
module sram #(
    parameter int unsigned WORDS = 2048,
    parameter int unsigned WIDTH = 30,
    localparam int unsigned ADDRESS_BITS = $clog2(WORDS)
) (
    input  logic                    clk,
    input  logic                    write,
    input  logic [ADDRESS_BITS-1:0] write_address,
    input  logic [WIDTH-1:0]        write_word,
    input  logic [ADDRESS_BITS-1:0] address,
    output logic [WIDTH-1:0]        word
);
  logic [WIDTH-1:0] words [WORDS]  /* verilator public_flat_rd */;
  assign word = words[address];
  always_ff @(posedge clk) if (write) words[write_address] <= write_word;
endmodule
