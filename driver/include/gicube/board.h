// The host's handle to one GI-Cube board: open it, load a volume and its tables, render or trace rays, read back.
//
//   auto board = gicube::Board::open("emu:");          // a private emulated board
//   board.load_volume(view);                           // voxels, gradients, blocks
//   board.set_transfer_function(transfer_function);    // segmentation LUT and empty flags
//   gicube::Image image = board.render(camera);        // simulated time: board.now()
//
// Sources: the coprocessor API of [P §3.5, §5.6]. Times are simulated; only the watchdog uses the wall clock. gicube/testing.h
// measures what happens between two points of simulated time (gicube::test::Window).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/counters.h"
#include "gicube/error.h"
#include "gicube/export.h"
#include "gicube/illumination.h"
#include "gicube/image.h"
#include "gicube/level_of_detail.h"
#include "gicube/material.h"
#include "gicube/pair.h"
#include "gicube/ray.h"
#include "gicube/scattering.h"
#include "gicube/shading.h"
#include "gicube/time.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube {

class RayExchange;  // gicube/ray_exchange.h

enum class Fidelity { kFunctional, kApproximate /* boards of 0.2 only */, kCycle };

// As in "emu:?fidelity=cycle".
constexpr const char* name_of(Fidelity level) {
  return level == Fidelity::kFunctional ? "functional" : level == Fidelity::kApproximate ? "approximate" : "cycle";
}

// What the card stores of a voxel (asic.voxel_format): the paper's 36 bits, or a colour besides (VolumeView::colours).
enum class VoxelFormat { kDensity, kRgb, kRgba };

// What the board said of itself when it was opened.
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

// What submit() does when OpenOptions::max_rays are under way.
enum class BackPressure {
  kWait,   // the simulated host waits for the oldest batch to complete
  kThrow,  // throws WouldBlock, and nothing is sent
};

struct OpenOptions {
  // Wall-clock limit for one answer of the board; 0 = none. Beyond it the call throws TimedOut.
  std::chrono::milliseconds watchdog{std::chrono::minutes{10}};
  // Rays that may be under way: submitted, and not yet completed by the simulated board. 4096 or more.
  std::size_t max_rays = std::size_t{1} << 22;
  // Rays that wait for blocks of a volume that the card does not store whole: so many stay on the card, as many more in the host's memory,
  // 128 bytes each, and others in a file without a name in the folder TMPDIR, or else in /var/tmp. 1024 or more.
  std::size_t max_waiting_rays = std::size_t{1} << 22;
  BackPressure back_pressure = BackPressure::kWait;
  // Keeps the volume's packed blocks in the host's memory, 4.5 bytes per stored voxel (7.5 with colours), so that reopen() can load them again.
  bool keep_volume = false;
  // How often in a row a call resumes a session that lost its connection, before it throws DeviceLost or TimedOut. A resumed
  // call goes on as if nothing had happened. Not for emu:, whose board ends with its connection.
  int reopen_attempts = 0;
  // Takes the board from its owner, whose calls then throw DeviceLost with Loss::kTakenOver.
  bool force = false;
  // How long open() waits in line while the board has an owner, before it throws BoardBusy. First come, first served.
  std::chrono::milliseconds wait_for_board{0};
  // Writes every frame of the session to this file, for gicube-replay (docs/guide/capture.md). New sessions of reopen() go
  // to FILE.1, FILE.2. Empty: the option capture of emu: names the file, or else the environment variable GICUBE_CAPTURE.
  // Only its user can read it. If it can't be written, the session ends: calls throw DeviceLost.
  std::string capture{};
  // Over TCP and TLS, a file of mode 600 with the access token for the board (docs/reference/security.md). Empty: the file that the
  // environment variable GICUBE_TOKEN_FILE names; without it, on this machine, the token that a board of this user has left.
  std::string token_file{};
  // Over TLS, a file with the certificates, PEM, of those who may have signed the board's. Empty: the file that the environment
  // variable GICUBE_CA_FILE names; without it, those that this machine trusts.
  std::string ca_file{};
  // The board is not reset, but goes on from the checkpoint that its process began with (gicube-board --restore FILE), which a driver
  // has saved by Board::save(). The option restore of emu: does the same.
  bool go_on = false;
  // Called on the thread of a call that waits for the board, some ten times a second of wall-clock time, and by open(). What it
  // throws leaves that call: an application that is told to stop can. The board works on: a picture is unknown then, the irradiance
  // incomplete, a loading volume lost; ray batches stay under way, and the Board takes the next call. It is not called while frames
  // wait to be sent. It may ask its Board for now() and info() only, and must outlive it.
  std::function<void()> while_waiting{};
};

// What Board::reopen() found.
struct Reopened {
  bool resumed = false;  // the same session goes on: nothing was lost
  bool volume = false;   // there is a volume on the board
};

// Parts done and parts in all of a long call; called on the calling thread, at the end with all of them.
using Progress = std::function<void(std::uint32_t done, std::uint32_t all)>;

// One Board owns one session, which ends with it. It can be moved, not copied; a moved-from Board may only be destroyed or
// assigned to. Several threads may call it: each call is one transaction, and they take turns.
class GICUBE_API Board {
 public:
  // Opens a board and resets it.
  //   emu:                  starts a private gicube-board child over a socket pair; it ends with this Board
  //   unix:PATH             a gicube-board that listens on a Unix socket
  //   tcp:HOST:PORT         the same on TCP
  //   tls:HOST:PORT         the same by TLS: gicube-board --tls-cert; OpenOptions::ca_file names who signed its certificate
  // emu: takes options, as in "emu:?fidelity=functional&bus=agp2x&set=asic.processors=8": fidelity, bus, pace, threads,
  // config=FILE, set=path.to.field=value and bsdf=FILE.so (both repeatable; a bsdf is code that the application trusts:
  // docs/guide/scattering_routines.md), faults=FILE, fault_log=FILE (docs/guide/faults.md), trace=FILE,
  // trace_window=BEGIN:END, events=FILE, events_of=ITEM,... (docs/guide/observation.md), capture=FILE
  // (docs/guide/capture.md), restore=FILE (docs/guide/checkpoints.md). The program is searched for in this order: by the environment variable GICUBE_BOARD, beside the running program, where the SDK was installed, on the PATH.
  // Throws BadArgument (URI; a value that the emulated board refuses, in its own words), OpenFailed, BoardBusy, VersionMismatch,
  // TimedOut.
  static Board open(std::string_view uri, const OpenOptions& options = {});

  // After DeviceLost or TimedOut: connects again by the same URI and options. If the board still has the session, the session
  // goes on: what was under way arrives exactly once, and the failed call may be made again. Else it is a new board (of emu: a
  // new process). The host's clock goes on; registers, tables and materials are written again, with OpenOptions::keep_volume
  // the volume too; irradiance, sums and framebuffer are lost. Ray batches that were not received are sent again once there
  // is a volume. On a Board that is not lost it does nothing and reports resumed.
  // Throws OpenFailed, BoardBusy, VersionMismatch, TimedOut, DeviceLost: the Board is still lost.
  Reopened reopen();

  // A checkpoint: all that the board is and that this Board knows of it, between two calls, ray batches under way included. A Board that goes
  // on from it, in this process or another, finds the same bits, times and counters as this one. In it are neither the options of open() nor
  // the application's scattering routine. It costs no simulated time and changes nothing. docs/guide/checkpoints.md.
  // Throws Unsupported (a board before protocol 2.3), Rejected (it is larger than the board holds for a client).
  std::vector<std::byte> save();
  // The same to a file that only its user can read, and that is whole or not there. Throws Error, too, if it can't be written.
  void save(const std::string& file);
  // This board goes on from a checkpoint of save(), and this Board with it: its clock is the one that was saved, its tickets are those. Set
  // the scattering routine again. The board's configuration may differ in what does not shape its state.
  // Throws BadArgument (a damaged checkpoint, by its field; a file that can't be read), Rejected (the board's own words: it is of another
  // configuration, or larger than the board takes), Unsupported: nothing has changed. If the board is lost meanwhile, and by
  // what OpenOptions::while_waiting throws while it goes on: reopen(), and restore it again.
  void restore(std::span<const std::byte> checkpoint);
  void restore(const std::string& file);

  Board(Board&&) noexcept;
  Board& operator=(Board&&) noexcept;
  ~Board();

  const BoardInfo& info() const;

  // Replaces the volume: converts the samples, quantises gradients by the codebook, cuts all into blocks and sends those that are
  // not zero including their shared faces. The simulated host waits for the transfer. The transfer functions are kept, and
  // the empty flags are found again.
  // A volume with more blocks than the card stores, (N / n)^3, is kept by the driver: pictures, rays and light have its blocks sent as
  // rays need them, also to a new board after reopen(), and have the same bits. Edges have up to 1024 voxels then. Rays of type
  // kBackproject, write_volume(), verify_volume(), sums, and the application's scattering routine throw Unsupported then
  // (docs/guide/bricks.md).
  // Throws BadArgument (dims, samples, spacing, range, NaN sample, gradients, tags, colours): the board keeps its volume. Throws Rejected
  // if the volume needs more memory than the board may take (gicube-board --max-memory): there is no volume then.
  // On DeviceLost or TimedOut the volume is lost with the board.
  void load_volume(const VolumeView& volume, const Progress& progress = {});
  // The same of a volume that is read in planes: some n + 3 of them are in memory at a time. The driver writes the blocks that are not
  // zero, 4.5 bytes a voxel, to a file without a name in the folder TMPDIR, or else in /var/tmp, and sends them from there; it keeps
  // the file if the card does not store the volume whole. Throws Error, too, if the file can't be written, and what `read` throws:
  // the board keeps its volume. Pictures throw Error if the file can't be read.
  void load_volume(const VolumeStream& volume, const Progress& progress = {});

  // The values of a box of the volume as the board holds them, 12 bits each, x fastest. The simulated host waits for the
  // transfer. Throws Rejected (no volume), BadArgument (box).
  std::vector<float> read_volume(const VoxelBox& box);
  // Overwrites a box of the volume, x fastest, with values in the volume's range (others are clamped). Tags and colours do not change.
  // Gradients of the box and its neighbours are found again, unless load_volume() was told to find none; so are the empty
  // flags. The simulated host waits for the transfers, which are of whole blocks in both directions.
  // Throws Rejected (no volume), BadArgument (box, a value's index): the volume is unchanged.
  void write_volume(const VoxelBox& box, std::span<const float> values);
  // Has the board read its whole volume back, and compares each block with what was written there. Returns the blocks that
  // differ, ascending, numbered as in empty_flags(). They lost bits unnoticed: pictures and rays since then may be wrong, and
  // the volume should be loaded again. The simulated host waits as long as the fullest memory channel needs to read its
  // blocks. Throws Rejected before load_volume(), MemoryFault.
  std::vector<std::size_t> verify_volume();

  // The loaded volume's size, voxels. Throws Rejected before load_volume().
  Dims dims() const;
  // The map from the loaded volume's values to densities. Throws Rejected before load_volume().
  ValueRange value_range() const;

  // Sets how tag `tag` (0..3) looks, writes its quarter of the segmentation LUT and finds the empty flags again. After
  // load_volume() the simulated host waits for that; a tag never set is invisible. Throws BadArgument: the board is untouched.
  void set_transfer_function(const TransferFunction& function, int tag = 0);

  // Phong coefficients and light of the next renderings. The reflectance map is made for each view's direction, and sent when
  // it changes. The simulated host waits for what must be sent at once. Throws BadArgument: the board is untouched.
  void set_shading(const Shading& shading);

  // How tag `tag` (0..3) scatters rays. Until then it does not. Throws BadArgument: the board is untouched.
  void set_material(const Material& material, int tag = 0);

  // Scatters the rays that meet a material with kTrap and kHostRoutine, in illuminate() and in pictures with View::scatter.
  // 64 bytes of each come over the bus, 32 go back, and the simulated host works `time_per_ray` on it. The routine may
  // ask this Board for now() and info() only. What it throws leaves the call that needed it; an answer that no ray can
  // follow throws ScatteringFailed. In both cases rays that had not ended are lost, the irradiance is incomplete, there is no
  // picture, and the board is ready for the next call. An empty routine removes the former one.
  void set_scattering_routine(ScatteringRoutine routine, Picoseconds time_per_ray = 0);

  // Clears the irradiance and distributes the lights' energy by lighting rays; the simulated host waits. The irradiance
  // remains until the next illuminate(), load_volume() or reset, for any number of renderings with View::irradiance.
  // Throws BadArgument (a light's index and field, settings), Rejected (no volume, no routine), Unsupported (the application's
  // scattering routine in a volume that the card does not store whole): the irradiance is incomplete.
  LightingReport illuminate(std::span<const Light> lights, const Illumination& settings, const Progress& progress = {});
  // One value per voxel, x fastest, in units of the lights' power: of the whole volume or of a box; with three irradiance words a
  // voxel's red, green and blue side by side. The simulated host waits for
  // the transfer. Throws Rejected before the first illuminate() or clear_irradiance(), BadArgument (box).
  std::vector<float> read_irradiance();
  std::vector<float> read_irradiance(const VoxelBox& box);
  // Overwrites it, with as many values: words are rounded to the unit in force and saturate. Throws as read_irradiance(), and BadArgument
  // (a value's index): the irradiance is unchanged. The simulated host waits for the transfer.
  void write_irradiance(const VoxelBox& box, std::span<const float> values);
  // Sets the irradiance to zero, and one unit of its words to `unit` of the lights' power: for kDeposit rays and
  // write_irradiance(). Words saturate at 2047, on the wide datapath at 2^32 - 1. Throws BadArgument, Rejected (no volume).
  void clear_irradiance(double unit);
  // Sets the sums of kBackproject rays to zero, and one unit of them to `unit`, an energy times a length.
  // They are kept in addition to the volume until the next load_volume() or reset. Throws BadArgument, Rejected (no volume).
  void clear_sums(double unit);
  // One sum a voxel, x fastest, of a box of the volume. Sums are clipped at 2^34 units; DepositReport counts them. The
  // simulated host waits for the transfer. Throws Rejected before the first clear_sums(), BadArgument (box).
  std::vector<float> read_sums(const VoxelBox& box);

  // Replaces the gradient codebook: at most 2048 unit directions, code 0 must be the zero vector ("no gradient").
  // The default has 40 latitude rings. Throws BadArgument, and Rejected once a volume is loaded: the board is untouched.
  void set_gradient_codebook(std::span<const Vec3> codebook);

  // Overrides the flags that the driver found, until the next load_volume() or set_transfer_function(). One value a
  // block, x fastest, nonzero = nothing visible. A flag that is set on a visible block hides that block.
  // Throws BadArgument if the count is not the volume's number of blocks: the board is untouched.
  void set_empty_flags(std::span<const std::uint8_t> flags);
  // The flags in force, one per block.
  std::vector<std::uint8_t> empty_flags() const;
  Dims blocks() const;  // how many blocks along each axis

  // Renders into the board's framebuffer; the simulated host waits for its completion but does not read the image. Throws
  // BadArgument (view's fields), Rejected (no volume, no scattering routine) and Unsupported (the application's scattering routine in
  // a volume that the card does not store whole): the framebuffer is unchanged.
  void render_to_framebuffer(const View& view, const Progress& progress = {});
  // Transfers the framebuffer at 36 bits per pixel. Throws Rejected before the first rendering.
  Image read_framebuffer();
  // Both.
  Image render(const View& view, const Progress& progress = {});
  // Empty if something can be seen in a picture of this board: a colour, or an alpha of a step of 8 bits. Else a sentence for people, which
  // ends with the likely reason: no transfer function, values that it does not show, empty flags, a camera that looks elsewhere, cut
  // planes. The last view rendered is taken into account. It costs no simulated time.
  std::string why_invisible(const Image& image) const;

  // Sends rays, in as many DSP commands as they need. The application's routine does not scatter them. Returns at once unless
  // too many are under way (OpenOptions::back_pressure); the simulated host goes on while the board works. Any number of
  // batches may be under way; the caller's memory is free again on return. If the card does not store the volume whole, the
  // simulated host waits for the rays, and the batch is complete on return; what the board refuses is thrown at once.
  // Throws BadArgument (a ray's index and field, the request's fields), Rejected (no volume; kDeposit before
  // clear_irradiance() or illuminate(), kBackproject before clear_irradiance() or clear_sums()), WouldBlock: nothing was sent.
  Ticket submit(std::span<const HostRay> rays, const RayRequest& request = {});
  // The same with rays that lie in several places, as one batch in that order.
  Ticket submit(std::span<const std::span<const HostRay>> rays, const RayRequest& request = {});
  Ticket submit(std::span<const Polyline> lines);
  // Blocks until that batch has returned, and moves the simulated host's clock to its arrival. Throws BadArgument if the ticket
  // is unknown or its rays were received already; Rejected, Unsupported if the board refused it: the batch is gone;
  // DeadlinePassed if it has not arrived by the simulated time `deadline`: the clock is there, the batch still under way.
  RayBatch receive(Ticket ticket, Picoseconds deadline = kNoDeadline);
  // The same, with the rays straight into the caller's memory: as many as were submitted (polylines: legs). None are written of
  // a cancelled batch, and of kDeposit and kBackproject, for which any size will do. Throws BadArgument if it has another size:
  // the batch is still there.
  BatchReport receive(Ticket ticket, std::span<TracedRay> rays, Picoseconds deadline = kNoDeadline);
  // The batches that have arrived by now() and were not received yet, in the order of their simulated arrival. If the board
  // refused one, that is thrown first (Rejected, Unsupported): it is gone, the others are still there.
  std::vector<RayBatch> poll();
  // Takes back the part of a batch that the DSP has not begun by now(). Its rays are lost, and receive() or poll() return it
  // as cancelled. False: it is too late, and the batch comes back whole. The simulated host waits for the answer.
  // Throws BadArgument if the ticket is unknown; Unsupported for kDeposit and kBackproject, which can't be taken back.
  bool cancel(Ticket ticket);

  // A file descriptor that poll(), epoll or an event loop can wait for: it becomes readable, and stays so, when receive() would
  // no longer have to wait for the board's work, or if the board is lost or the Board is destroyed. Don't read from it. It is the
  // caller's to close, at any time. It moves no clock: receive() does, as ever.
  // The board answers once it has worked out all that was sent before this call, so ask right after submit(). With
  // `pace: realtime` receive() may still wait until the wall clock has come to the batch's arrival. After reopen() on a new board
  // ask again. Throws BadArgument as receive(), Error if the process has no descriptor left.
  int descriptor(Ticket ticket);
  // receive() as a future: get() and wait() call it, on their thread, and the simulated clock moves then. So it is a deferred one:
  // wait_for() says std::future_status::deferred. When a batch arrives in simulated time depends on what else the host does
  // before it waits, so a thread of the driver can't wait in its place. To wait in wall-clock time use descriptor(). The future may outlive this Board, and never hangs: if the Board is destroyed, before get() or while it waits, that
  // throws DeviceLost (Loss::kClosed). Throws BadArgument as receive().
  std::future<RayBatch> future(Ticket ticket);

  // How much light goes between pairs of elements: one factor per pair. Near pairs are divided
  // (PairFactor). The simulated host waits. With PairRays::kByHost it makes rays in no time, unless the application adds
  // host_compute(). Pairs with nothing but empty blocks between them (empty_flags(), if PairRequest::leap is on) are summed up by
  // the driver, without rays: PairFactor::clear.
  // Throws BadArgument (an element's, a pair's index, the request's fields), Rejected (no volume): nothing was sent.
  std::vector<PairFactor> pair_factors(std::span<const Element> elements, std::span<const ElementPair> pairs,
                                       const PairRequest& request = {}, const Progress& progress = {});

  // The simulated host's clock, since open().
  Picoseconds now() const;
  // The host works for that long; the board goes on meanwhile.
  void host_compute(Picoseconds duration);
  // From now on a rendering or an illuminate() for which the simulated host would wait longer than `limit` throws
  // DeadlinePassed, with the clock at that deadline. The board finishes its command, but the result is lost: the
  // framebuffer's content is unknown, the irradiance is that of the whole pass. 0: no limit.
  void set_time_limit(Picoseconds limit);

  // Level of detail in volumes that the card does not store whole [P §5.3]. Where 2, 4 or 8 voxels are at most `detail` pixels wide, a
  // block is sent as the means of cells of so many voxels an edge, an 8th, 64th or 512th of its bytes, and the card gives its voxels
  // these values. 1: cells are no larger than a pixel; 0, the default: blocks are as they are. Of a block the part nearest to the eye
  // counts; near the eye, for scattered pictures, host rays and light they are as they are. So a picture depends on its view alone.
  // Throws BadArgument (detail: 0..64), Unsupported (a board before protocol 2.3).
  void set_brick_detail(double detail);
  // What the last picture had of it; nothing if the card stores the volume whole. Throws Rejected if there is no picture.
  std::optional<BrickDetail> brick_detail();

  // Traces volumes together with the boards of other hosts, the ranks of one job. Each rank loads the same volume, tables and materials,
  // and its card is sent only its own blocks of the volume and their faces; rays that come to others' blocks go there (RayExchange), and
  // come home at their ends. Bits are those of one endless card. From now on these calls are collective: load_volume(), render(),
  // render_to_framebuffer(), read_framebuffer(), illuminate(), submit(). All ranks give the same view, lights and settings, and get the whole
  // picture, report and irradiance; host rays are each rank's own, and come back to it, but the report of rays that leave energy is all
  // ranks'. Blocks are dealt anew when one rank has taken over a tenth more samples than the mean. Calls that need the volume on one card
  // throw Unsupported, and so do pair_factors() and save(). If a rank throws, the job must end (RayExchange).
  // Throws BadArgument (exchange), Rejected (a volume is loaded), Unsupported (a board before protocol 2.3, a card of less than 8 blocks).
  void share_blocks(std::shared_ptr<RayExchange> exchange);

  Counters counters();

 private:
  friend class BoardGroup;  // gicube/board_group.h
  struct State;
  explicit Board(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;  // futures have weak ones
};

}  // namespace gicube
