// A processor's two buffers of runs (asic/raybus/ray_bus.h): it extrapolates its own rays of the older one, one per
// cycle. `own` marks these among the run's rays.
module run_buffer #(
    parameter int unsigned RUN_BITS = 8,
    parameter int unsigned RUN_RAYS = 64,
    localparam int unsigned INDEX_BITS = $clog2(RUN_RAYS)
) (
    input  logic                  clk,
    input  logic                  rst,
    input  logic                  takes_in,  // at the cycle's end; ignored if no ray of the run is its own
    input  logic [RUN_BITS-1:0]   run,
    input  logic [RUN_RAYS-1:0]   own,
    input  logic                  ready,  // the processor's FIFO takes a ray
    input  logic                  ray_goes,  // a ray from the bus goes to it
    output logic                  has_room,
    output logic                  bus_may_send,  // the run's ray has had its turn
    output logic                  push,
    output logic [RUN_BITS-1:0]   push_run,
    output logic [INDEX_BITS-1:0] push_index
);
  logic [1:0] count  /* verilator public_flat_rd */;
  logic [2*RUN_BITS-1:0] runs  /* verilator public_flat_rd */;  // the older one first
  logic [2*RUN_RAYS-1:0] rests  /* verilator public_flat_rd */;  // own rays that are still to come
  logic run_had_turn  /* verilator public_flat_rd */;

  logic [RUN_RAYS-1:0] rest;
  logic ends, appends;
  logic [1:0] kept;
  assign has_room = count < 2'd2;
  assign bus_may_send = count == 2'd0 || run_had_turn;
  assign push = count != 2'd0 && ready && !ray_goes;
  assign push_run = runs[RUN_BITS-1:0];
  assign rest = rests[RUN_RAYS-1:0] & (rests[RUN_RAYS-1:0] - 1'b1);
  assign ends = push && rest == '0;
  assign appends = takes_in && own != '0;
  assign kept = count - 2'(ends);
  always_comb begin
    push_index = '0;
    for (int i = RUN_RAYS - 1; i >= 0; i--) if (rests[i]) push_index = INDEX_BITS'(i);
  end

  always_ff @(posedge clk) begin
    if (rst) begin
      count <= '0;
      run_had_turn <= 1'b0;
    end else begin
      count <= kept + 2'(appends);
      if (push) run_had_turn <= 1'b1;
      else if (ray_goes) run_had_turn <= 1'b0;
    end
    if (ends) begin
      runs <= runs >> RUN_BITS;
      rests <= rests >> RUN_RAYS;
    end else if (push) begin
      rests[RUN_RAYS-1:0] <= rest;
    end
    if (appends) begin
      runs[32'(kept)*RUN_BITS +: RUN_BITS] <= run;
      rests[32'(kept)*RUN_RAYS +: RUN_RAYS] <= own;
    end
  end
endmodule
