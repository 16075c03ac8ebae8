// Rays that a host application makes itself, its requests, and the returned rays.
//
//   gicube::Ticket ticket = board.submit(rays, {.type = gicube::RayType::kFirstHit, .opacity = 0.5});
//   ...                                                      // the board works meanwhile
//   gicube::RayBatch hits = board.receive(ticket);
//
// Sources: [P §3.5, §3.6] host rays; [P §5.6] a ray between two voxels whose opacity comes back.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "gicube/export.h"
#include "gicube/illumination.h"
#include "gicube/time.h"
#include "gicube/vector.h"
#include "gicube/view.h"

namespace gicube {

// The task of a batch's rays.
enum class RayType {
  // Colour and opacity from its position until it leaves the volume, meets a cut plane, or has
  // Sampling::opacity_threshold. Scattered if Sampling::scatter says so. With jitter.
  kIntegrate,
  // Until the opacity that it has gathered reaches RayRequest::opacity: its position is then that of the sample which
  // brought it there, and its opacity at least that. A ray with less has hit nothing and ends where it left the volume
  // or met a cut plane. No colour. With jitter.
  kFirstHit,
  // Colour and opacity between two points, `length` apart, or up to the first sample at which RayRequest::opacity is
  // reached. Its own step divides the length evenly, at most RayRequest::step, and it samples the middle of each: so
  // both directions see the same samples. Neither jitter nor cut planes.
  kSegment,
  // Like kSegment without colour: the transmittance between two points is 1 - opacity.
  kOpacity,
  // Distributes its energy into the irradiance words on its way (docs/reference/hardware.md, Global illumination), by
  // RayRequest::albedo and rules. No ray comes back; BatchReport::lighting says where the energy went.
  kDeposit,
  // The line integral of the volume's values less ValueRange::low between two points, lengths in the unit of
  // VolumeView::spacing. Sampled as kSegment; opacities, empty blocks, jitter and cut planes don't matter. It
  // may end outside of the volume, but must begin inside like every ray: use clip_to_volume() for sources
  // outside.
  kIntegral,
  // Adds `energy` for each unit of length to the voxels along its way from one point to another. The ray loses nothing
  // by that. RayRequest::words says to which words; no ray comes back.
  kBackproject,
};

// The words to which rays of type kBackproject add.
enum class SumWords {
  kIrradiance,  // what read_irradiance() reads: not negative, 11 bits or 32 on the wide datapath, by clear_irradiance()
  kSums,        // the whole 36-bit words: signed sums of whole units, by clear_sums() and read_sums()
};

// Values that the board cannot hold exactly are rounded: positions to 1/16384 voxel, directions to 1/16384, lengths to
// 1/65536 voxel.
struct HostRay {
  std::uint32_t id = 0;  // the caller's own; comes back unchanged. kDeposit: seeds its random choices
  Vec3 position{};       // voxels, inside the volume: 0..size - 1 on each axis
  Vec3 direction{};      // any length but 0; only the direction counts
  // kSegment, kOpacity, kIntegral, kBackproject: voxels along the direction, 0..4096. A ray of length 0, the default,
  // is legitimate and takes no sample: it returns with opacity and integral 0.
  double length = 0;
  // kDeposit: > 0, in units of the lights' power. kBackproject: for each unit of length; into sums with either sign
  double energy = 0;
};

// The ray from one point to another, both in voxels, for ray types with a length. Equal points: length 0, along z.
GICUBE_API HostRay ray_between(std::uint32_t id, Vec3 from, Vec3 to);
// The part of a ray with a length (voxels; infinite: a half line) that is inside a volume of `dims` voxels, 0..size - 1
// on each axis; the ray may begin outside. Nothing if it misses the volume, or meets it in one point only. The line
// integral over the part equals that over the whole.
GICUBE_API std::optional<HostRay> clip_to_volume(const HostRay& ray, const Dims& dims);

// How rays are sampled, as the fields of View of the same names; step and leaping are RayRequest's. sampling_of() takes
// it from a view.
struct Sampling {
  bool jitter = false;
  std::vector<CutPlane> cut_planes{};  // at most 6
  std::uint32_t seed = 0;              // of scatterings' and deposits' random choices
  // kIntegrate, kSegment; the threshold, scattering and its lifetime of kIntegrate only.
  double opacity_threshold = 0.98;
  bool shade = true;
  bool irradiance = false;
  bool incident = false;
  double exposure = 0;
  bool scatter = false;
  bool high_albedo = false;
  int lifetime = 8;
  Vec3 looking{0, 0, 1};  // from the eye into the volume, voxels, any length but 0: highlights are those that it sees
};

// That of the view's own rays.
GICUBE_API Sampling sampling_of(const View& view);

struct RayRequest {  // the request for the rays of a batch
  RayType type = RayType::kIntegrate;
  double opacity = 1;  // kFirstHit, kSegment, kOpacity: > 0..1
  // kDeposit, as in Illumination:
  Albedo albedo = Albedo::kLow;
  EnergyRules rules = EnergyRules::kConserving;
  int lifetime = 32;
  SumWords words = SumWords::kSums;  // kBackproject
  double step = 0.5;                 // voxels between samples, 1/64..16; refused as View::step
  bool leap = true;                  // over blocks whose empty flag is set; kIntegral, kBackproject never do
  Sampling sampling{};
};

// A ray as it returned.
struct TracedRay {
  std::uint32_t id = 0;
  Vec3 position;                   // where it ended, clamped to the volume; voxels
  Vec3 direction;                  // unit length in voxels
  std::array<double, 3> colour{};  // premultiplied, 0..1
  double opacity = 0;              // 0..1
  double integral = 0;             // kIntegral

  friend constexpr bool operator==(const TracedRay&, const TracedRay&) = default;
};

// Names one submitted batch until its rays have been received.
struct Ticket {
  std::uint32_t id = 0;
  friend constexpr bool operator==(Ticket, Ticket) = default;
};

// The sums of a batch of type kBackproject: kept + clipped in all.
struct DepositReport {
  std::uint64_t rays = 0;
  std::uint64_t samples = 0;
  double kept = 0;               // in the units of HostRay::energy times length
  double clipped = 0;            // by words that were full: the words read back are wrong by that much
  std::uint64_t overflowed = 0;  // sums that were full; every command that would change one further counts it again
  double unit = 0;               // of one unit of the words
};

// The completion of a batch, and the sums that its rays left on the board.
struct BatchReport {
  Ticket ticket;
  Picoseconds completed = 0;               // simulated time at which the last byte reached the host
  bool cancelled = false;                  // some of its rays were never traced; none come back
  std::optional<LightingReport> lighting;  // kDeposit
  std::optional<DepositReport> deposits;   // kBackproject
};

// A ray batch that has come back.
struct RayBatch : BatchReport {
  // In the order in which they were submitted. kDeposit, kBackproject: none.
  std::vector<TracedRay> rays;
};

}  // namespace gicube
