// One processor's sorter (asic/sorter/sorter.h, [P §3.2]): rays enter, wait in the queue of their block, and leave
// from the most important queue. The steps of a cycle are those of Sorter::work().
//
// A token, from its lowest bit: queue, processor (8 bits), contribution (12), state (3), has_reserved_slot, the ray.
module sorter #(
    parameter int unsigned QUEUES = 128,
    parameter int unsigned RAYS = 256,  // of a queue
    parameter int unsigned RAY = 32,    // bits of a ray, or of its handle
    parameter int unsigned POLICY = 0,
    parameter int unsigned IMPORTANCE_BITS = 9,
    parameter int unsigned RESERVED = 64,  // reserved slots that are not yet reported
    localparam int unsigned QUEUE_BITS = $clog2(QUEUES),
    localparam int unsigned TOKEN = RAY + 24 + QUEUE_BITS
) (
    input  logic                  clk,
    input  logic                  rst,
    input  logic [7:0]            processor,
    // From the pipeline, the bus, the left and the right link.
    input  logic [3:0]            arrives,
    input  logic [4*TOKEN-1:0]    tokens,
    output logic [3:0]            pops,
    input  logic                  is_released,
    input  logic [QUEUE_BITS-1:0] released,
    input  logic                  issue_ready,
    output logic                  issues,
    output logic [TOKEN-1:0]      issued,
    input  logic                  overflow_ready,
    output logic                  overflows,
    output logic [TOKEN-1:0]      overflowed,  // a ray, or a reserved slot
    output logic                  moves,       // a ray, a slot or an importance moved
    // Counts: a second write lost; a ray without a slot; a slot reported; a queue activated, given up,
    // inserted.
    output logic                  conflicts,
    output logic                  finds_no_slot,
    output logic                  reports_slot,
    output logic                  activates,
    output logic                  gives_up,
    output logic                  inserts,
    output logic                  loses_slot   // a fault: more reserved slots than RESERVED
);
  localparam int unsigned PROCESSOR_AT = QUEUE_BITS;
  localparam int unsigned CONTRIBUTION_AT = QUEUE_BITS + 8;
  localparam int unsigned STATE_AT = QUEUE_BITS + 20;
  localparam int unsigned FLAG_AT = QUEUE_BITS + 23;
  localparam logic [2:0] OVERFLOWED = 3'd2, SLOT = 3'd5;
  localparam int unsigned COUNT_BITS = $clog2(QUEUES * RAYS + 1);

  logic has_active  /* verilator public_flat_rd */;
  logic [QUEUE_BITS-1:0] active  /* verilator public_flat_rd */;
  logic [QUEUE_BITS-1:0] latest_active  /* verilator public_flat_rd */;
  logic [31:0] issued_since_active  /* verilator public_flat_rd */;
  logic [1:0] turn  /* verilator public_flat_rd */;
  logic [IMPORTANCE_BITS-1:0] openings  /* verilator public_flat_rd */;
  logic [COUNT_BITS-1:0] waiting  /* verilator public_flat_rd */;

  logic [QUEUES-1:0] reserves, has_slot, has_two_slots, is_open, is_empty;
  logic [QUEUES*TOKEN-1:0] fronts;
  logic [QUEUES*IMPORTANCE_BITS-1:0] importances;

  // A queue becomes active, and its first ray is issued.
  logic has_top, has_items, can_insert, shift_up;
  logic [QUEUE_BITS-1:0] top, now_active;
  logic is_active;
  assign activates = !has_active && waiting != '0 && has_top;
  assign is_active = has_active || activates;
  assign now_active = has_active ? active : top;
  assign issues = is_active && issue_ready;
  always_comb begin
    issued = '0;
    for (int unsigned q = 0; q < QUEUES; q++) begin
      if (now_active == QUEUE_BITS'(q)) issued = issued | fronts[q*TOKEN +: TOKEN];
    end
  end

  // Rays that arrive: the pipeline's first, then the others in turns. At most two are written, to different queues.
  logic [1:0] next_turn, turns, written;
  logic [TOKEN-1:0] written_0, written_1, lost;
  logic stops;
  always_comb begin
    logic [1:0] at, after;
    logic [TOKEN-1:0] token;
    logic [QUEUE_BITS-1:0] number, latest;
    logic is_latest, latest_flag, fits, comes;
    pops = '0;
    written = '0;
    written_0 = '0;
    written_1 = '0;
    lost = '0;
    finds_no_slot = 1'b0;
    conflicts = 1'b0;
    stops = 1'b0;
    turns = 2'd2;
    next_turn = turn;
    latest = '0;
    latest_flag = 1'b0;
    after = turn;
    for (int unsigned k = 0; k < 4; k++) begin
      at = k == 0 ? 2'd0 : after + 2'd1;  // of the inputs; `after` and turn: 0 bus, 1 left, 2 right
      token = '0;
      for (int unsigned i = 0; i < 4; i++) if (at == 2'(i)) token = token | tokens[i*TOKEN +: TOKEN];
      comes = arrives[at] && !stops && turns != 2'd0;
      number = token[QUEUE_BITS-1:0];
      is_latest = written != 2'd0 && number == latest;
      fits = token[FLAG_AT] || (is_latest && !latest_flag ? has_two_slots[number] : has_slot[number]);
      if (k != 0) after = after == 2'd2 ? 2'd0 : after + 2'd1;
      if (comes && k != 0 && is_latest && fits) begin
        conflicts = 1'b1;
        stops = 1'b1;
        next_turn = at - 2'd1;
      end else if (comes && (fits || (overflow_ready && !finds_no_slot))) begin
        pops[at] = 1'b1;
        turns = turns - 2'd1;
        if (k != 0) next_turn = after;
        if (fits) begin
          if (written == 2'd0) written_0 = token;
          else written_1 = token;
          written = written + 2'd1;
          latest = number;
          latest_flag = token[FLAG_AT];
        end else begin
          finds_no_slot = 1'b1;
          lost = token;
        end
      end
    end
  end

  // Slots that are reserved for overflowed rays, in the order of their release. The oldest is reported if no ray
  // overflows; also one that was reserved in this cycle.
  logic reserves_one, has_reserved;
  logic [$clog2(RESERVED+1)-1:0] reserved_size;
  logic [QUEUE_BITS-1:0] oldest_reserved;
  assign reserves_one = |reserves;
  assign has_reserved = reserved_size != '0;
  assign reports_slot = (has_reserved || reserves_one) && overflow_ready && !finds_no_slot;
  assign loses_slot = reserves_one && !reports_slot && reserved_size == ($clog2(RESERVED+1))'(RESERVED);
  fifo #(.WIDTH(QUEUE_BITS), .PLACES(RESERVED)) reserved (
      .clk, .rst, .push(reserves_one && !(reports_slot && !has_reserved)), .push_item(released),
      .pop(reports_slot && has_reserved), .front(oldest_reserved), .size(reserved_size));

  assign overflows = finds_no_slot || reports_slot;
  always_comb begin
    overflowed = lost;
    overflowed[STATE_AT +: 3] = OVERFLOWED;
    if (!finds_no_slot) begin
      overflowed = '0;
      overflowed[QUEUE_BITS-1:0] = has_reserved ? oldest_reserved : released;
      overflowed[PROCESSOR_AT +: 8] = processor;
      overflowed[STATE_AT +: 3] = SLOT;
    end
  end

  // Numbers of openings, which start again when no ray waits.
  logic [COUNT_BITS-1:0] rest;
  logic [IMPORTANCE_BITS-1:0] opening_0, opening_1, opened_0;
  logic opens_0, opens_1;
  assign rest = waiting - COUNT_BITS'(issues);
  assign opens_0 = written != 2'd0 && !is_open[written_0[QUEUE_BITS-1:0]];
  assign opens_1 = written == 2'd2 && !is_open[written_1[QUEUE_BITS-1:0]];
  assign opening_0 = rest == '0 ? '0 : openings + 1'b1;
  assign opened_0 = opens_0 ? opening_0 : openings;
  assign opening_1 = opened_0 + 1'b1;

  for (genvar q = 0; q < QUEUES; q++) begin : gen_queue
    logic [TOKEN-1:0] front, written_here;
    logic write_0, write_1;
    assign write_0 = written != 2'd0 && written_0[QUEUE_BITS-1:0] == QUEUE_BITS'(q);
    assign write_1 = written == 2'd2 && written_1[QUEUE_BITS-1:0] == QUEUE_BITS'(q);
    always_comb begin
      written_here = write_0 ? written_0 : written_1;
      written_here[FLAG_AT] = 1'b0;
    end
    assign fronts[q*TOKEN +: TOKEN] = front;
    queue #(.RAYS(RAYS), .TOKEN(TOKEN), .CONTRIBUTION_AT(CONTRIBUTION_AT), .POLICY(POLICY),
            .IMPORTANCE_BITS(IMPORTANCE_BITS)) one (
        .clk, .rst, .released(is_released && released == QUEUE_BITS'(q)), .reserves(reserves[q]),
        .has_slot(has_slot[q]), .has_two_slots(has_two_slots[q]), .read(issues && now_active == QUEUE_BITS'(q)), .front,
        .is_open(is_open[q]), .overflows(finds_no_slot && lost[QUEUE_BITS-1:0] == QUEUE_BITS'(q)), .write(write_0 || write_1),
        .write_reserved(write_0 ? written_0[FLAG_AT] : written_1[FLAG_AT]), .write_token(written_here),
        .write_opening(write_0 ? opening_0 : opening_1), .is_empty(is_empty[q]),
        .importance(importances[q*IMPORTANCE_BITS +: IMPORTANCE_BITS]));
  end

  // An empty active queue leaves the ranks; a hole at the top too. One changed queue is inserted.
  logic [QUEUE_BITS-1:0] first;
  logic has_first;
  logic [IMPORTANCE_BITS-1:0] first_importance;
  assign gives_up = is_active && is_empty[now_active];
  assign shift_up = gives_up || (!is_active && !has_top && has_items);
  assign inserts = has_first && can_insert;
  always_comb begin
    first_importance = '0;
    for (int unsigned q = 0; q < QUEUES; q++) begin
      if (first == QUEUE_BITS'(q))
        first_importance = first_importance | importances[q*IMPORTANCE_BITS +: IMPORTANCE_BITS];
    end
  end
  changed_queues #(.QUEUES(QUEUES), .QUEUE_BITS(QUEUE_BITS)) changed (
      .clk, .rst, .remove(activates), .removed(top),
      .change({written == 2'd2 && !(is_active && written_1[QUEUE_BITS-1:0] == now_active),
               written != 2'd0 && !(is_active && written_0[QUEUE_BITS-1:0] == now_active)}),
      .changed_0(written_0[QUEUE_BITS-1:0]), .changed_1(written_1[QUEUE_BITS-1:0]), .has_first, .first,
      .take_first(inserts));
  insertion_sorter #(.QUEUES(QUEUES), .QUEUE_BITS(QUEUE_BITS), .IMPORTANCE_BITS(IMPORTANCE_BITS)) ranks (
      .clk, .rst, .has_top, .top, .has_items, .activate_top(activates), .shift_up, .can_insert, .insert(inserts),
      .insert_queue(first), .insert_importance(first_importance));

  assign moves = is_released || issues || (|pops) || reports_slot || shift_up || inserts;

  always_ff @(posedge clk) begin
    if (rst) begin
      has_active <= 1'b0;
      active <= '0;
      latest_active <= '0;
      issued_since_active <= '0;
      turn <= '0;
      openings <= '0;
      waiting <= '0;
    end else begin
      has_active <= is_active && !gives_up;
      active <= now_active;
      if (activates) latest_active <= top;
      issued_since_active <= (activates ? 32'd0 : issued_since_active) + 32'(issues);
      turn <= next_turn;
      openings <= opens_1 ? opening_1 : opened_0;
      waiting <= rest + COUNT_BITS'(written);
    end
  end
endmodule
