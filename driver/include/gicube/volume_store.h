// The volume on a board: loading, reading and changing it (Board::volume()).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "gicube/export.h"
#include "gicube/level_of_detail.h"
#include "gicube/pending.h"
#include "gicube/volume.h"

namespace gicube {

struct BoardState;

class GICUBE_API VolumeStore {
 public:
  explicit VolumeStore(BoardState& of) : state_(&of) {}

  // Replaces the volume: converts the samples, quantises gradients by the codebook, divides all into blocks and sends
  // those that are not zero including their shared faces. The simulated host waits for the transfer. The transfer
  // functions are kept, and the empty flags are recomputed.
  // A volume with more blocks than the card stores, (N / n)^3, is kept by the driver: pictures, rays and light have its
  // blocks sent as rays need them, also to a new board after reopen(), and have the same bits. Edges have up to 1024
  // voxels then. Rays of type kBackproject, write(), verify(), sums, and the application's scattering routine throw
  // Unsupported then (docs/guide/bricks.md). Throws BadArgument (dims, samples, spacing, range, NaN sample, gradients,
  // tags, colours): the board keeps its volume. Throws Rejected if the volume needs more memory than the board may take
  // (gicube-board --max-memory): there is no volume then. On DeviceLost or TimedOut the volume is lost with the board.
  void load(const VolumeView& volume, const Progress& progress = {});
  // Loads a volume that is read in planes: about n + 3 planes are in memory at a time. The driver writes the blocks
  // that are not zero, 4.5 bytes per voxel, to a file without a name in the folder TMPDIR, or else in /var/tmp, and
  // sends them from there; it keeps the file if the card does not store the volume whole. Throws Error, too, if the
  // file can't be written, and what `read` throws: the board keeps its volume. Pictures throw Error if the file can't
  // be read.
  void load(const VolumeStream& volume, const Progress& progress = {});
  // load(), started: the samples must stay where they are until it has ended; a stream is read on a thread of the
  // driver.
  Pending<void> start_load(const VolumeView& volume);
  Pending<void> start_load(const VolumeStream& volume);

  // The volume's size, voxels. Throws Rejected before load().
  Dims dims() const;
  // The map from the volume's values to densities. Throws Rejected before load().
  ValueRange value_range() const;

  // The values of a box of the volume as the board holds them, 12 bits each, x fastest. The simulated host waits for
  // the transfer. Throws Rejected (no volume), BadArgument (box).
  std::vector<float> read(const VoxelBox& box);
  // Reads into the caller's memory, one value per voxel. Throws BadArgument, too, if it has another size.
  void read(const VoxelBox& box, std::span<float> values);
  // Overwrites a box of the volume, x fastest, with values in the volume's range (others are clamped). Tags and colours
  // do not change. Gradients of the box and its neighbours are found again, unless load() was told to find none; so are
  // the empty flags. The simulated host waits for the transfers, which are of whole blocks in both directions.
  // Throws Rejected (no volume), BadArgument (box, a value's index): the volume is unchanged.
  void write(const VoxelBox& box, std::span<const float> values);
  // Has the board read its whole volume back, and compares each block with what was written there. Returns the blocks
  // that differ, ascending, numbered as in empty_flags(). Their bits changed unnoticed: later pictures and rays may be
  // wrong, and the volume should be loaded again. The simulated host waits as long as the fullest memory channel needs
  // to read its blocks. Throws Rejected before load(), MemoryFault.
  std::vector<std::size_t> verify();

  // How many blocks along each axis, and one flag per block, x fastest: nonzero = nothing visible. Throw Rejected
  // before load().
  Dims blocks() const;
  std::vector<std::uint8_t> empty_flags() const;
  // Overrides the flags that the driver found, until the next load() or transfer function. A flag that is set on a
  // visible block hides that block. Throws BadArgument if the count is not the volume's number of blocks: the board is
  // untouched.
  void set_empty_flags(std::span<const std::uint8_t> flags);

  // Level of detail in volumes that the card does not store whole [P §5.3]. Where 2, 4 or 8 voxels are at most `detail`
  // pixels wide, a block is sent as the means of cells of so many voxels an edge, an 8th, 64th or 512th of its bytes,
  // and the card gives its voxels these values. 1: cells are no larger than a pixel; 0, the default: full blocks. The
  // corner nearest to the eye decides a block's level; scattered pictures, host rays and light use full blocks. So a
  // picture depends on its view alone. Throws BadArgument (detail: 0..64), Unsupported (a board before protocol 2.3).
  void set_detail(double detail);
  // The level of detail of the last picture; nothing if the card stores the volume whole. Throws Rejected if there is
  // no picture.
  std::optional<BrickDetail> detail();

 private:
  BoardState* state_;
};

}  // namespace gicube
