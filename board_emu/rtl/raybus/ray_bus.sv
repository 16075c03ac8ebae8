// The ray bus from the DSP to the processors (asic/raybus/ray_bus.h, [P §3.6]): one packet per cycle. A ray is one
// packet, a run two.
module ray_bus #(
    parameter int unsigned PROCESSORS = 4,
    parameter int unsigned RUN_BITS = 8,
    parameter int unsigned RUN_RAYS = 64,
    localparam int unsigned INDEX_BITS = $clog2(RUN_RAYS)
) (
    input  logic                             clk,
    input  logic                             rst,
    input  logic                             has_ray,
    input  logic [7:0]                       destination,  // of the ray
    output logic                             takes_ray,
    input  logic                             has_run,
    input  logic [RUN_BITS-1:0]              run,
    input  logic [PROCESSORS*RUN_RAYS-1:0]   own,  // by processor, which of the run's rays are its own
    output logic                             takes_run,
    input  logic [PROCESSORS-1:0]            ready,
    output logic [PROCESSORS-1:0]            push_ray,
    output logic [PROCESSORS-1:0]            push_run_ray,  // ray `index` of `push_run`
    output logic [PROCESSORS*RUN_BITS-1:0]   push_run,
    output logic [PROCESSORS*INDEX_BITS-1:0] index,
    output logic                             busy,
    output logic                             waits
);
  logic sending  /* verilator public_flat_rd */;  // the second packet of a run is next
  logic run_next  /* verilator public_flat_rd */;
  logic [RUN_BITS-1:0] sent_run  /* verilator public_flat_rd */;
  logic [PROCESSORS*RUN_RAYS-1:0] sent_own;
  logic [PROCESSORS-1:0] has_room, may_send, is_owner;
  logic ray_can_go, run_can_go;

  for (genvar p = 0; p < PROCESSORS; p++) begin : gen_processor
    assign is_owner[p] = destination == 8'(p);
    assign push_ray[p] = takes_ray && is_owner[p];
    run_buffer #(.RUN_BITS(RUN_BITS), .RUN_RAYS(RUN_RAYS)) buffer (
        .clk, .rst, .takes_in(sending), .run(sent_run), .own(sent_own[p*RUN_RAYS +: RUN_RAYS]), .ready(ready[p]),
        .ray_goes(push_ray[p]), .has_room(has_room[p]), .bus_may_send(may_send[p]), .push(push_run_ray[p]),
        .push_run(push_run[p*RUN_BITS +: RUN_BITS]), .push_index(index[p*INDEX_BITS +: INDEX_BITS]));
  end

  assign ray_can_go = has_ray && (is_owner & may_send & ready) != '0;
  assign run_can_go = has_run && (&has_room);
  assign takes_run = !sending && run_can_go && (run_next || !ray_can_go);
  assign takes_ray = !sending && ray_can_go && !takes_run;
  assign busy = sending || takes_run || takes_ray;
  assign waits = !busy && (has_ray || has_run);

  always_ff @(posedge clk) begin
    if (rst) begin
      sending <= 1'b0;
      run_next <= 1'b0;
    end else begin
      sending <= takes_run;
      if (takes_run) run_next <= 1'b0;
      else if (takes_ray) run_next <= 1'b1;
    end
    if (takes_run) begin
      sent_run <= run;
      sent_own <= own;
    end
  end
endmodule
