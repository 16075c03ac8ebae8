// The state behind a Board handle.
#pragma once

#include <atomic>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "batches.h"
#include "bricks/bricks.h"
#include "bricks/ray_queue.h"
#include "bricks/shared_blocks.h"
#include "calls/started_calls.h"
#include "device.h"
#include "encode/volume/planes.h"
#include "encode/volume/voxel_blocks.h"
#include "gicube/board.h"
#include "gicube/wire/checksum.h"
#include "gicube/wire/command.h"
#include "gicube/wire/forwarded_ray.h"
#include "gicube/wire/memory_map.h"
#include "gicube/wire/trap.h"
#include "tables.h"

namespace gicube {

// The part of a loaded volume that the driver keeps, for instance to compute the empty flags again.
struct LoadedVolume {
  Dims dims{};
  Dims blocks{};
  ValueRange range;
  Vec3 relative_spacing;
  double min_spacing = 1;  // smallest edge of VolumeView::spacing
  bool coloured = false;   // its voxels have colours
  bool gradients = true;   // false: there are none (VolumeView::find_gradients)
  std::vector<BlockStatistics> statistics;
  std::vector<std::uint8_t> flags;  // in force, one per block
};

// A Board's state apart from its device, its tables and its batches.
struct Remembered {
  BoardInfo info;
  Picoseconds time_limit = 0;  // of a rendering or an illumination; 0: none
  std::optional<LoadedVolume> volume;
  std::unique_ptr<Bricks> bricks;  // the blocks, if the card does not store the volume whole
  std::map<std::uint32_t, std::vector<std::uint8_t>> kept_blocks;  // packed, as last written; with keep_volume
  bool blocks_are_kept = false;                                    // kept_blocks has all that are not zero
  bool batches_wait = false;                                       // until a volume is loaded on a new board
  std::vector<std::uint32_t> block_sums;                           // CRC-32C of each block's words as they were written
  std::vector<std::uint32_t> colour_sums;                          // of its colours; 0: none. Of a coloured volume
  double irradiance_unit = 0;                                      // power of one unit; 0 before the first illuminate()
  double sum_unit = 0;                                             // of the sums; 0 before the first clear_sums()
  double bright_flux = 0;                                          // of the automatic exposure
  View sampling;                                                   // the last view rendered
  std::pair<int, int> framebuffer_size{};                          // pixels; 0 before the first rendering

  // Throws CheckpointFault. `kept`: the volume's blocks are wanted for reopen().
  void state(Archive& archive, bool kept);
};

struct GICUBE_HIDDEN BoardState : Remembered, std::enable_shared_from_this<BoardState> {
  BoardState(const Uri& uri, const OpenOptions& options)
      : keep_volume(options.keep_volume),
        max_waiting_rays(options.max_waiting_rays),
        ray_queue(options.max_waiting_rays),
        threads(uri.threads),
        device(uri, options,
               [this, application = options.while_waiting] {
                 if (started.is_here()) {
                   started.check();
                 } else if (application) {
                   application();
                 }
               }),
        tables(device),
        batches(device, options) {}
  ~BoardState() { end(); }

  // Ends the session. All waiting calls throw DeviceLost.
  void end() {
    device.close();
    started.end();
  }

  // Throws Rejected while the batches wait for a volume.
  void need_batches() const {
    if (batches_wait) throw Rejected("the ray batches wait for a volume on the new board: call load_volume() first");
  }
  bool is_in_callback() const { return in_callback.load() == std::this_thread::get_id(); }
  // Waits for a turn. Throws Error in a callback of a running call.
  Turns::Turn lock() {
    if (is_in_callback()) throw Error("a callback may ask its Board for now() and info() only");
    if (started.is_here()) return {};
    return turns.take();
  }
  // Begins a public call: all but now(), info() and reopen() are one transaction. Throws DeviceLost.
  Turns::Turn begin() {
    auto held = lock();
    device.check();
    return held;
  }
  // Executes `work(progress)`, a call of this Board, on another thread, in its place in the order of calls.
  template <class T>
  Pending<T> start(std::function<T(const Progress&)> work) {
    if (is_in_callback()) throw Error("a callback may ask its Board for now() and info() only");
    return Pending<T>(started.start<T>(turns, std::move(work), [this] { return device.clock().now(); }));
  }
  Pending<RayBatch> handle_of(Ticket ticket);
  // Marks a callback of the application: while it exists, this Board refuses calls of its thread.
  class InCallback {
   public:
    explicit InCallback(BoardState& state) : who_(state.in_callback) { who_ = std::this_thread::get_id(); }
    ~InCallback() { who_ = std::thread::id(); }
    InCallback(const InCallback&) = delete;
    InCallback& operator=(const InCallback&) = delete;

   private:
    std::atomic<std::thread::id>& who_;
  };
  // The caller's callback, marked by InCallback; empty if `progress` is.
  Progress watched(const Progress& progress) {
    if (!progress) return {};
    return [this, &progress](std::uint32_t done, std::uint32_t all) {
      const InCallback mark(*this);
      progress(done, all);
    };
  }
  // The loaded volume. Throws Rejected that names `what` if there is none.
  LoadedVolume& loaded(const char* what) {
    if (!volume) throw Rejected(std::string(what) + " needs a volume: call load_volume() first");
    return *volume;
  }

  // The loaded volume. Throws Unsupported if the card does not store it whole.
  LoadedVolume& whole(const char* what);
  std::size_t capacity_blocks() const {  // how many the card stores
    const auto edge = static_cast<std::size_t>(info.max_volume_voxels / info.block_voxels);
    return edge * edge * edge;
  }
  // Throw Unsupported: need_no_routine_in_bricks() if the card does not store the volume whole and the application
  // scatters a material that rays meet; need_colours_on_card(), for boards with three irradiance words, if the card
  // does not store the volume whole or the application scatters any material.
  void need_colours_on_card(const char* what);
  void need_no_routine_in_bricks(const char* what, bool lighting);

  // How the rays of a command that wait for blocks are continued.
  struct BrickRun {
    BrickNeeds needs{};
    // Orders the blocks to send, most important first. Empty: Bricks::by_importance().
    std::function<std::vector<std::size_t>(std::span<const wire::WaitingBlock>)> order{};
    // For rays that deposit: takes the ledger with which each completion begins. Empty: there is none.
    std::function<void(const wire::LightingLedger&)> take_ledger{};
    Picoseconds deadline = kNoDeadline;
    wire::GiveRaysHeader of{};  // the command of these rays, for other ranks
  };
  // Continues rays until none waits. `payload`: of the completion of the command that made them.
  void run_in_bricks(std::span<const std::uint8_t> payload, const BrickRun& run) {
    run_waiting(take_waiting(payload, run), run);
  }
  void run_waiting(std::vector<wire::WaitingBlock> waiting, const BrickRun& run);
  void queue_excess(std::vector<wire::WaitingBlock>& waiting);
  std::vector<wire::WaitingBlock> with_queue(std::span<const wire::WaitingBlock> waiting) const;
  void give_queued(std::span<const wire::WaitingBlock> waiting, const BrickRun& run);
  std::vector<wire::WaitingBlock> take_waiting(std::span<const std::uint8_t> payload, const BrickRun& run);
  void deposit_for_board(std::uint32_t records, wire::LightingLedger& ledger);
  // Execute trace commands. They return the results that the commands would give if the card stored the whole volume.
  static constexpr std::size_t kMaxTracedAtOnce =
      wire::kMaxHostRays / 4;  // chosen: 128 MB of packets, which may all wait
  std::vector<CommandResult> trace_in_bricks(std::span<const EncodedRays> parts, const BrickRun& run);
  std::vector<CommandResult> deposit_in_bricks(std::span<const EncodedRays> parts, const BrickRun& run);
  // Whether parts are left on any rank. Collective.
  bool any_left(std::size_t parts) { return shared ? shared->exchange().sum(parts) > 0 : parts > 0; }
  void trace_group(std::span<const EncodedRays> parts, const BrickRun& run, std::vector<CommandResult>& results);
  // For a job of several ranks (forward_rays.cpp), collective. Sends the rays that wait for the blocks `others` to
  // their ranks, and lists in `waiting` those that then wait here. False: no rank has sent a ray.
  bool forward(std::span<const wire::WaitingBlock> others, std::vector<wire::WaitingBlock>& waiting,
               const BrickRun& run);
  std::vector<wire::WaitingBlock> give_rays(std::vector<std::uint8_t> rays, std::vector<std::uint8_t> ended,
                                            const wire::GiveRaysHeader& of);
  // The bytes of each rank, by rank. All simulated hosts continue at the latest of their times.
  std::vector<std::vector<std::uint8_t>> gather(std::vector<std::uint8_t> own);
  void begin_shared_light();
  void end_shared_light(wire::LightingLedger& ledger);
  wire::LightingLedger sum_of_ranks(const wire::LightingLedger& ledger);
  void share_anew();
  // Throws Unsupported if the board shares its volume's blocks with others.
  void need_all_blocks(const char* what) const;
  // The part of a picture that render() makes (wire::RenderCommand). For a part without rows it only remembers the
  // view.
  struct PicturePart {
    std::uint16_t strip_rows = 0;
    std::uint8_t part = 0, parts = 0;
  };
  // `tables_there`: called once the view's tables are on the board, for which the simulated host then waits.
  void render(const View& view, const PicturePart& part, const Progress& progress,
              const std::function<void()>& tables_there = {});
  Image read_picture();                        // the rows that this board has made
  void read_picture(std::span<Pixel> pixels);  // the same, into `pixels`
  Image gather_picture();
  // levels_of(): the level of detail of each block; empty: all in full. picture_run(): the run of a picture's rays.
  std::vector<std::uint8_t> levels_of(const View& view) const;
  BrickRun picture_run(const View& view, const wire::RenderCommand& camera, Picoseconds deadline);

  static wire::Spacing spacing_words(Vec3 relative) {  // of the SPACING registers
    const auto word = [](double edge) { return static_cast<std::uint32_t>(std::lround(edge * wire::kSpacingOne)); };
    return {word(relative.x), word(relative.y), word(relative.z)};
  }
  // For a new board: restores the state of the lost one as far as the driver knows it.
  void restore();
  // Passes a checkpoint to `sink` in pieces (saved_state.cpp).
  void save(const std::function<void(std::span<const std::uint8_t>)>& sink);
  // Continues from a checkpoint. Throws BadArgument, Rejected: nothing has changed.
  void go_on(std::span<const std::uint8_t> checkpoint);
  // After opening: continues from the checkpoint of the board's process. Throws OpenFailed.
  void go_on();
  void remember(std::span<const std::uint8_t> part, const wire::WentOn& now);
  int max_edge() const;  // of a volume, voxels
  void check_colours(bool given) const;
  void load(Planes planes, const Progress& progress);
  void forget_volume();
  using BlockTaker = std::function<void(std::size_t block, std::span<const std::uint8_t> packed)>;
  void for_each_block(Planes& planes, LoadedVolume& of, const Progress& progress, const BlockTaker& take);
  BlockStore keep_blocks(Planes& planes, LoadedVolume& of, const Progress& progress);
  void begin_volume(const LoadedVolume& volume);
  void begin_blocks(const LoadedVolume& of);
  // `packed`: as VoxelBlocks::pack() makes it, or without colours: then the block's colours do not change.
  void write_block(std::size_t block, std::span<const std::uint8_t> packed) {
    const std::size_t n = static_cast<std::size_t>(info.block_voxels), words = bytes_of_words(n);
    if (keep_volume) {
      auto& kept = kept_blocks[static_cast<std::uint32_t>(block)];
      if (kept.size() < packed.size()) kept.resize(packed.size());
      std::copy(packed.begin(), packed.end(), kept.begin());
    }
    block_sums[block] = wire::crc32c(packed.first(words));
    if (packed.size() > words) colour_sums[block] = wire::crc32c(packed.subspan(words));
    write_packed_block(device, block, n, packed);
  }
  // Read boxes of words in the application's units (board_regions.cpp).
  void read_volume(const VoxelBox& box, std::span<float> values);
  void read_irradiance(const VoxelBox& box, std::span<float> values);
  void read_sums(const VoxelBox& box, std::span<float> values);
  std::vector<float> irradiance_of(const VoxelBox& box);
  std::vector<float> values_of(const VoxelBox& box, const char* what, std::size_t of_voxel,
                               void (BoardState::*read)(const VoxelBox&, std::span<float>));
  // Clears the words that `bits` of CONTROL select, and sets their unit.
  void clear_words(const char* what, std::uint32_t bits, double unit, double& kept_unit);
  void check_fence();
  void find_flags(LoadedVolume& of) {
    of.flags = find_empty_blocks(of.statistics, tables.segmentation());
    tables.send_flags(of.flags);
  }
  // The likely reason why a picture shows nothing.
  std::string why_invisible() const;
  // Throws BadArgument if the positions of rays could drift by more than a voxel over the volume in steps of `step`
  // voxels.
  void check_drift(const char* field, double step) const;
  void set_sampling(const View& view);
  // `numbers`: index of each span's first ray, for error messages; empty: the spans are consecutive.
  Ticket submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request,
                std::span<const std::size_t> numbers = {});
  void send_batches_again() {
    batches.send_again([this](const View& view, Vec3 towards_eye) {
      set_sampling(view);
      if (view.shade) tables.send_reflectance(towards_eye);
    });
  }
  // Factors of pairs without dividing near ones. The volume is loaded and everything is checked.
  std::vector<PairFactor> factors_by_rays(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                          const PairRequest& request, const Progress& progress);
  // The deadline of a call that begins now.
  Picoseconds deadline() const {
    const Picoseconds now = device.clock().now();
    return time_limit == 0 || time_limit > kNoDeadline - now ? kNoDeadline : now + time_limit;
  }
  void set_lighting(const Illumination& settings);
  void prepare_light(const Light& light);
  // Throws Rejected if a material that the rays can meet needs the application's routine and none is set.
  void need_routine(bool lighting) const;
  // Answers trapped rays, from the list in a command's result on, until none waits on the board. `take_ledger` gets the
  // ledgers, if the rays deposit.
  using TakeLedger = std::function<void(const wire::LightingLedger&)>;
  void scatter_waiting(std::span<const std::uint8_t> trap_list, const TakeLedger& take_ledger);
  double exposure_of(const View& view) const;
  std::uint32_t exposure_word(const View& view) const;

  const bool keep_volume;
  const std::size_t max_waiting_rays;  // on the card, and as many with the host
  RayQueue ray_queue;
  const unsigned threads;  // for the driver's own work; 0: one per core
  Turns turns;             // of the calls
  StartedCalls started;
  std::atomic<std::thread::id> in_callback{};
  Device device;
  Tables tables;
  Batches batches;
  double detail = 0;                                        // set_brick_detail()
  std::vector<std::uint8_t> block_levels;                   // of the current picture; empty: full blocks
  std::unique_ptr<SharedBlocks> shared;                     // after share_blocks()
  bool may_have_ended = false;                              // the board may have ended rays of other ranks
  std::uint64_t samples_before = 0;                         // counter at the last share_anew()
  ScatteringRoutine scattering_routine;                     // the application's; empty: none
  Picoseconds time_per_scattering = 0;                      // of the host
  bool restoring = false;                                   // restore() has begun and not ended
  std::map<std::uint32_t, std::uint32_t> registers_before;  // of the lost board
};

}  // namespace gicube
