// The host's handle to one GI-Cube board: open it, load a volume and its tables, render or trace rays, read back.
//
//   auto board = gicube::Board::open("emu:");          // a private emulated board
//   board.load_volume(view);                           // voxels, gradients, blocks
//   board.set_transfer_function(transfer_function);    // segmentation LUT and empty flags
//   gicube::Image image = board.render(camera);        // simulated time: board.now()
//
// Sources: the coprocessor API of [P §3.5, §5.6]. Times are simulated; only the watchdog uses the wall clock.
// gicube/testing.h measures what happens between two points of simulated time (gicube::test::Window).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gicube/counters.h"
#include "gicube/error.h"
#include "gicube/export.h"
#include "gicube/illuminator.h"
#include "gicube/look_up_tables.h"
#include "gicube/pair_integrator.h"
#include "gicube/pending.h"
#include "gicube/ray_tracer.h"
#include "gicube/renderer.h"
#include "gicube/time.h"
#include "gicube/volume_store.h"

namespace gicube {

class RayExchange;  // gicube/ray_exchange.h
struct BoardState;  // the driver's own

enum class Fidelity { kFunctional, kApproximate /* boards of 0.2 only */, kCycle };

// The name in a URI, for instance "emu:?fidelity=cycle".
constexpr const char* name_of(Fidelity level) {
  return level == Fidelity::kFunctional ? "functional" : level == Fidelity::kApproximate ? "approximate" : "cycle";
}

// The voxels that the card stores (asic.voxel_format): the paper's 36 bits, or also a colour (VolumeView::colours).
enum class VoxelFormat { kDensity, kRgb, kRgba };

// Properties that the board reported when it was opened.
struct BoardInfo {
  int protocol_major = 0;
  int protocol_minor = 0;  // the smaller of both sides
  Fidelity fidelity = Fidelity::kFunctional;
  int processors = 0;
  int block_voxels = 0;       // n, voxels
  int max_volume_voxels = 0;  // N: the card stores the blocks of N^3 voxels
  int queue_rays = 0;
  std::uint32_t core_khz = 0;
  std::uint64_t config_hash = 0;  // of the board's resolved configuration
  std::uint16_t vendor_id = 0;    // PCI configuration space
  std::uint16_t device_id = 0;
  bool wide = false;       // the wide datapath (asic.datapath)
  bool agp = false;        // the card has an AGP capability
  bool host_rays = false;  // submit() is offered
  VoxelFormat voxel_format = VoxelFormat::kDensity;
  int irradiance_words = 1;  // of a voxel (asic.irradiance_words): 1, or 3 for red, green and blue
};

// Behaviour of submit() when OpenOptions::max_rays are under way.
enum class BackPressure {
  kWait,   // the simulated host waits for the oldest batch to complete
  kThrow,  // throws WouldBlock, and nothing is sent
};

struct OpenOptions {  // how a board is opened
  // Wall-clock limit for one answer of the board; 0 = none. Beyond it the call throws TimedOut.
  std::chrono::milliseconds watchdog{std::chrono::minutes{10}};
  // Rays that may be under way: submitted, and not yet completed by the simulated board. 4096 or more.
  std::size_t max_rays = std::size_t{1} << 22;
  // Rays that wait for blocks of a volume that the card does not store whole: this many stay on the card, as many more
  // in the host's memory, 128 bytes each, and the rest in an unnamed file in the folder TMPDIR, or else in /var/tmp.
  // 1024 or more.
  std::size_t max_waiting_rays = std::size_t{1} << 22;
  BackPressure back_pressure = BackPressure::kWait;
  // Keeps the volume's packed blocks in the host's memory, 4.5 bytes per stored voxel (7.5 with colours), so that
  // reopen() can load them again.
  bool keep_volume = false;
  // Times in a row that a call resumes a session that lost its connection, before it throws DeviceLost or TimedOut. A
  // resumed call continues unchanged. Not for emu:, whose board ends with its connection.
  int reopen_attempts = 0;
  // Takes the board from its owner, whose calls then throw DeviceLost with Loss::kTakenOver.
  bool force = false;
  // Time that open() waits in the queue while the board has an owner, before it throws BoardBusy.
  std::chrono::milliseconds wait_for_board{0};
  // Writes every frame of the session to this file, for gicube-replay (docs/guide/capture.md). New sessions of reopen()
  // go to FILE.1, FILE.2. Empty: the option capture of emu: names the file, or else the environment variable
  // GICUBE_CAPTURE. Only its user can read it. If it can't be written, the session ends: calls throw DeviceLost.
  std::string capture{};
  // Over TCP, TLS and PCI, a file of mode 600 with the access token for the board (docs/reference/security.md). Empty:
  // the file that the environment variable GICUBE_TOKEN_FILE names; without it, on this machine, the token that a board
  // of this user has left.
  std::string token_file{};
  // Over TLS, a file with the certificates (PEM) that may have signed the board's. Empty: the file that the
  // environment variable GICUBE_CA_FILE names; without it, those that this machine trusts.
  std::string ca_file{};
  // The board is not reset, but continues from the checkpoint of its process (gicube-board --restore FILE),
  // which a driver has saved by Board::save(). The option restore of emu: does the same.
  bool go_on = false;
  // Called on the thread of a call that waits for the board, some ten times a second of wall-clock time, and by open().
  // An exception thrown by it propagates out of the waiting call, so an application can stop early. The board
  // continues: a picture is then undefined, the irradiance incomplete, a loading volume lost; ray batches stay under
  // way, and the Board accepts the next call. It is not called while frames wait to be sent, nor for calls that were
  // started (gicube/pending.h). It may only call now() and info() of its Board, and must outlive it.
  std::function<void()> while_waiting{};
  // Receives a sentence about each event that no call reports: a session that was lost and resumed, and why. Called on
  // the thread of the call that resumed it. It must not throw, and may only call info() of its Board.
  std::function<void(const std::string&)> log{};
};

// The result of Board::reopen().
struct Reopened {
  bool resumed = false;  // the same session continues: nothing was lost
  bool volume = false;   // there is a volume on the board
};

// One Board owns one session, which ends with it. It can be moved, not copied; a moved-from Board may only be destroyed
// or assigned to. Several threads may call it: each call is one transaction, and they take turns in the order in which
// they were made.
class GICUBE_API Board {
 public:
  // Opens a board and resets it.
  //   emu:                  starts a private gicube-board child over a socket pair; it ends with this Board
  //   unix:PATH             a gicube-board that listens on a Unix socket
  //   tcp:HOST:PORT         the same on TCP
  //   tls:HOST:PORT         the same by TLS: gicube-board --tls-cert; OpenOptions::ca_file names who signed its
  //                         certificate
  //   pci:0000:00:04.0      a PCI function of this machine, a guest, that gicube-pci serves (docs/guide/pci.md); it has
  //                         one session, so wait_for_board does not wait for another process to end
  // emu: takes options, as in "emu:?fidelity=functional&bus=agp2x&set=asic.processors=8": fidelity (functional, cycle),
  // bus (pci33, agp1x, agp2x, agp4x), pace (as_fast_as_possible, realtime), threads (0..1024, 0: one per core of the
  // host), config=FILE, set=path.to.field=value and bsdf=FILE.so (both repeatable; a bsdf is code that the application
  // trusts: docs/guide/scattering_routines.md), faults=FILE, fault_log=FILE (docs/guide/faults.md), trace=FILE,
  // trace_window=BEGIN:END, events=FILE, events_of=ITEM,... (docs/guide/observation.md), capture=FILE
  // (docs/guide/capture.md), restore=FILE (docs/guide/checkpoints.md). The program is searched for in this order: by
  // the environment variable GICUBE_BOARD, beside the running program, where the SDK was installed, on the PATH. Throws
  // BadArgument (URI; a value that the emulated board refuses, in its own words), OpenFailed, BoardBusy,
  // VersionMismatch, TimedOut.
  static Board open(std::string_view uri, const OpenOptions& options = {});

  // After DeviceLost or TimedOut: connects again by the same URI and options. If the board still has the session, it
  // continues: all results under way arrive exactly once, and the failed call may be repeated. Otherwise it is a new
  // board (of emu: a new process). The host's clock continues; registers, tables and materials are written again, with
  // OpenOptions::keep_volume the volume too; irradiance, sums and framebuffer are lost. Ray batches that were not
  // received are sent again once there is a volume. On a Board that is not lost it does nothing and reports resumed.
  // Throws OpenFailed, BoardBusy, VersionMismatch, TimedOut, DeviceLost: the Board is still lost.
  Reopened reopen();

  // A checkpoint: the whole state of the board and of this Board, between two calls, including ray batches under way. A
  // Board that continues from it, in this process or another, gets the same bits, times and counters as this one. It
  // contains neither the options of open() nor the application's scattering routine. It costs no simulated time
  // and changes nothing. docs/guide/checkpoints.md. Throws Unsupported (a board before protocol 2.3), Rejected (it is
  // larger than the board holds for a client).
  std::vector<std::byte> save();
  // Saves to a file that only its user can read. The file is complete or does not exist. Also throws Error if it cannot
  // be written.
  void save(const std::string& file);
  // The board and this Board continue from a checkpoint of save(), with its clock and tickets. Set the scattering
  // routine again. The board's configuration may differ in fields that do not shape its state. Throws BadArgument (a
  // damaged checkpoint, by its field; a file that can't be read), Rejected (with the board's message: another
  // configuration, or too large), Unsupported: nothing has changed. If the board is lost meanwhile, or
  // OpenOptions::while_waiting throws: reopen(), and restore it again.
  void restore(std::span<const std::byte> checkpoint);
  void restore(const std::string& file);

  Board(Board&&) noexcept;
  Board& operator=(Board&&) noexcept;
  ~Board();

  const BoardInfo& info() const;

  // The parts of a board. Each is a view of this Board, as cheap as a pointer, and is valid as long as it.
  VolumeStore volume() const { return VolumeStore(*state_); }
  LookUpTables tables() const { return LookUpTables(*state_); }
  Renderer renderer() const { return Renderer(*state_); }
  RayTracer rays() const { return RayTracer(*state_); }
  Illuminator light() const { return Illuminator(*state_); }
  PairIntegrator pairs() const { return PairIntegrator(*state_); }

  // The simulated host's clock, since open(). It waits for started calls, so that the result does not depend on the
  // wall clock; but not on the thread of a callback.
  Picoseconds now() const;
  // The host computes for that long; the board continues meanwhile.
  void host_compute(Picoseconds duration);
  // From now on a rendering or an illuminate() for which the simulated host would wait longer than `limit` throws
  // DeadlinePassed, with the clock at that deadline. The board finishes its command, but the result is lost: the
  // framebuffer's content is unknown, the irradiance is that of the whole pass. 0: no limit.
  void set_time_limit(Picoseconds limit);

  // Traces volumes together with the boards of other hosts, the ranks of one job. Each rank loads the same volume,
  // tables and materials, and its card is sent only its own blocks of the volume and their faces; rays that come to
  // others' blocks go there (RayExchange), and return at their ends. Bits are those of one large card. From now on
  // these calls are collective: load_volume(), render(), render_to_framebuffer(), read_framebuffer(), illuminate(),
  // submit(). All ranks give the same view, lights and settings, and get the whole picture, report and irradiance; host
  // rays are each rank's own, and come back to it, but the report of rays that leave energy is all ranks'. Blocks are
  // dealt again when one rank has taken over a tenth more samples than the mean. Calls that need the volume on one card
  // throw Unsupported, and so do pair_factors() and save(). If a rank throws, the job must end (RayExchange). Throws
  // BadArgument (exchange), Rejected (a volume is loaded), Unsupported (a board before protocol 2.3, a card of less
  // than 8 blocks).
  void share_blocks(std::shared_ptr<RayExchange> exchange);

  Counters counters();

  // The calls of the parts by their names of version 0.2; each is the part's.
  void load_volume(const VolumeView& of, const Progress& progress = {}) { volume().load(of, progress); }
  void load_volume(const VolumeStream& of, const Progress& progress = {}) { volume().load(of, progress); }
  std::vector<float> read_volume(const VoxelBox& box) { return volume().read(box); }
  void write_volume(const VoxelBox& box, std::span<const float> values) { volume().write(box, values); }
  std::vector<std::size_t> verify_volume() { return volume().verify(); }
  Dims dims() const { return volume().dims(); }
  ValueRange value_range() const { return volume().value_range(); }
  Dims blocks() const { return volume().blocks(); }
  std::vector<std::uint8_t> empty_flags() const { return volume().empty_flags(); }
  void set_empty_flags(std::span<const std::uint8_t> flags) { volume().set_empty_flags(flags); }
  void set_brick_detail(double detail) { volume().set_detail(detail); }
  std::optional<BrickDetail> brick_detail() { return volume().detail(); }
  void set_transfer_function(const TransferFunction& function, int tag = 0) {
    tables().set_transfer_function(function, tag);
  }
  void set_shading(const Shading& shading) { tables().set_shading(shading); }
  void set_material(const Material& material, int tag = 0) { tables().set_material(material, tag); }
  void set_scattering_routine(ScatteringRoutine routine, Picoseconds time_per_ray = 0) {
    tables().set_scattering_routine(std::move(routine), time_per_ray);
  }
  void set_gradient_codebook(std::span<const Vec3> codebook) { tables().set_gradient_codebook(codebook); }
  Image render(const View& view, const Progress& progress = {}) { return renderer().render(view, progress); }
  void render_to_framebuffer(const View& view, const Progress& progress = {}) {
    renderer().render_to_framebuffer(view, progress);
  }
  Image read_framebuffer() { return renderer().read_framebuffer(); }
  std::string why_invisible(const Image& image) const { return renderer().why_invisible(image); }
  Ticket submit(std::span<const HostRay> of, const RayRequest& request = {}) { return rays().submit(of, request); }
  Ticket submit(std::span<const std::span<const HostRay>> of, const RayRequest& request = {}) {
    return rays().submit(of, request);
  }
  RayBatch receive(Ticket ticket, Picoseconds deadline = kNoDeadline) { return rays().receive(ticket, deadline); }
  BatchReport receive(Ticket ticket, std::span<TracedRay> traced, Picoseconds deadline = kNoDeadline) {
    return rays().receive(ticket, traced, deadline);
  }
  std::vector<RayBatch> poll() { return rays().poll(); }
  bool cancel(Ticket ticket) { return rays().cancel(ticket); }
  int descriptor(Ticket ticket) { return rays().descriptor(ticket); }
  LightingReport illuminate(std::span<const Light> lights, const Illumination& settings,
                            const Progress& progress = {}) {
    return light().illuminate(lights, settings, progress);
  }
  std::vector<float> read_irradiance() { return light().read(); }
  std::vector<float> read_irradiance(const VoxelBox& box) { return light().read(box); }
  void write_irradiance(const VoxelBox& box, std::span<const float> values) { light().write(box, values); }
  void clear_irradiance(double unit) { light().clear(unit); }
  void clear_sums(double unit) { light().clear_sums(unit); }
  std::vector<float> read_sums(const VoxelBox& box) { return light().read_sums(box); }
  std::vector<PairFactor> pair_factors(std::span<const Element> elements, std::span<const ElementPair> of,
                                       const PairRequest& request = {}, const Progress& progress = {}) {
    return pairs().factors(elements, of, request, progress);
  }

 private:
  friend class BoardGroup;  // gicube/board_group.h
  explicit Board(std::shared_ptr<BoardState> state);
  std::shared_ptr<BoardState> state_;  // handles of rays have weak ones
};

}  // namespace gicube
