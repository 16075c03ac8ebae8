// Volumetric radiosity with the board's form factors: the zonal method (Hottel and Sarofim 1967; Rushmeier and Torrance
// 1987) over a hierarchy of voxels (Hanrahan, Salzman and Aupperle 1991) [P §5.6].
//
//   RadiosityResult result = solve_radiosity(board, setup, emissions, {.error = 1e-4});
//   result.leaves[i].cell, .facing      // which voxel, which of its faces
//   result.outgoing[i]                  // its radiosity, red green blue
//
// Elements. A voxel is the box of half a voxel around its centre, cut at the volume's ends. It is solid if its opacity
// is at least RadiositySettings::solid_opacity, else open. Elements are
//   - faces between an open voxel and a solid one: they have Lambert's law and the solid's material;
//   - medium, the open voxels with opacity: they absorb, and scatter isotropically;
//   - the volume's ends at open voxels: they are black, and absorb the light that leaves the volume.
//
// Units. Lengths, areas and volumes are physical, in smallest voxel edges. kappa is extinction per length. The weight w
// of an element is its area, or 4 kappa V for medium. Radiosity B is the power that leaves a unit of weight; a medium
// element radiates 4 kappa V B. Incident H is the power that arrives at a unit of weight, so that
//
//   B = E + albedo H,   w_i H_i = sum over j of X_ij B_j, sum over j of X_ij = w_i (closure), X_ij = X_ji (reciprocity)
//
// with X the exchange areas of the zonal method: double integrals of (cos or kappa) (cos or kappa) T / (pi r^2).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "gicube/board.h"
#include "gicube/pair.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::samples {

using Power = std::array<double, 3>;  // red, green, blue; linear, in any unit that all powers of a solution share

inline double total(const Power& power) { return power[0] + power[1] + power[2]; }
// to += factor * what
template <std::size_t N>
void add(std::array<double, N>& to, double factor, const std::array<double, N>& what) {
  for (std::size_t c = 0; c < N; ++c) to[c] += factor * what[c];
}

using Edges = std::array<double, 3>;  // of a voxel, physical: in smallest voxel edges

enum class Solver {
  kGathering,  // all clusters gather over all links at once (Jacobi)
  kShooting,   // the clusters with the most unsent power send it (Southwell)
};

// Isotropic emission of a material, in power per unit: of a solid's surface or a medium's volume.
struct Emission {
  Power surface{}, volume{};
};
using Emissions = std::vector<Emission>;  // by tag; missing ones are dark

struct RadiositySettings {
  double solid_opacity = 0.5;  // > 0..1, of one voxel length
  double error = 1e-5;         // > 0: refines links that may misplace more than this share of the emitted power
  int rays = 16;               // of a link's first estimate; 8..65536
  int max_rays = 1024;         // of a link between elements that can't be divided; rays..2^24
  // Step of the rays in voxels, 1/64..16. A ray that cuts less than this of a solid's edge may miss it: a room with a
  // block of two voxels closes within 0.6% at 0.25, 0.16% at 1/16.
  double step = 0.125;
  std::uint32_t seed = 0;  // another seed is an independent experiment
  Solver solver = Solver::kGathering;
  PairRays made = PairRays::kByBoard;
  bool hierarchy = true;      // false: a link for each pair of leaves
  double convergence = 1e-4;  // > 0: share of the emitted power that may be in transit when the solver stops
  int max_iterations = 1000;  // of a solve
  bool balance = true;        // scales the uncertain part of the links until each element's sum closes
  int leaf_voxels = 1;        // edge of the cubes that are not divided, voxels: 1, 2, 4, ...
};

constexpr std::uint8_t kMedium = 6;     // Leaf::facing: no face
constexpr std::uint8_t kOutside = 255;  // Leaf::tag of the volume's ends

// One element.
struct Leaf {
  Element element;            // voxels
  std::uint8_t facing = 0;    // the normal of a face, into the open voxel: 0..5 = -x +x -y +y -z +z; or kMedium
  std::uint8_t tag = 0;       // material of the solid or the medium; kOutside
  double share = 1;           // of a face: area of its part of the true surface over its own
  std::array<int, 3> cell{};  // the open voxel; a face's solid voxel is one step back along its normal
  double weight = 0;          // w: area, or 4 kappa V
  double kappa = 0;           // of medium: mean extinction
  Power albedo{};
  Power emission{};  // E: emitted radiosity
};
// The solid voxel behind a face, a voxel outside the volume behind its ends, or the medium's own.
std::array<int, 3> voxel_behind(const Leaf& leaf);

constexpr std::uint32_t kNone = 0xFFFF'FFFF;

// A node of one of seven trees: the leaves of one facing within a cube of voxels.
struct Cluster {
  std::uint32_t first = 0, last = 0;  // leaves [first, last)
  std::uint32_t child = kNone;        // the first one; kNone: not divided
  std::uint32_t children = 0;         // number of adjacent children
  std::uint32_t parent = kNone;
  std::uint8_t facing = 0;
  bool full = false;                    // fills its box: it is one Element for the board
  std::array<double, 3> low{}, high{};  // box around its leaves, voxels
  double measure = 0;                   // physical area or volume
  double weight = 0;                    // sum of its leaves' w
};

struct Link {
  std::uint32_t a = 0, b = 0;  // clusters; a == b: within one
  double exchange = 0;         // X, an area
  double standard_error = 0;   // of X, from the spread of its samples
  double spread = 0;           // of X's samples: a subdivision may find it
  std::uint32_t rays = 0;      // requested
};

// Calls visit(to, from) for both directions of a link; once for one within a cluster.
template <typename Visit>
void both_ways(const Link& link, const Visit& visit) {
  visit(link.a, link.b);
  if (link.a != link.b) visit(link.b, link.a);
}

struct Iteration {
  std::uint32_t links = 0;  // current number
  double residual = 0;      // power in transit after it, a share of the emitted power
};

// Balance of the emitted power by channels: emitted = absorbed_by_faces + absorbed_by_medium + escaped + under_way +
// closure. closure is the power that the links' sums miss (positive) or exceed; about 0 if they are balanced.
struct EnergyBalance {
  Power emitted{}, absorbed_by_faces{}, absorbed_by_medium{}, escaped{}, under_way{}, closure{};
  Power measured_closure{};  // closure of the links before balancing
};

struct RadiosityStatistics {
  std::uint64_t faces = 0, medium = 0, ends = 0, clusters = 0, links = 0;
  std::uint64_t all_pairs = 0;        // of leaves whose sides can see each other: a full matrix's links
  std::uint64_t pairs = 0, rays = 0;  // traced by the board
  std::uint64_t refinements = 0;      // divided links
  std::vector<Iteration> iterations;
  EnergyBalance energy;
  double closure_rms = 0;  // root mean square of (sum over j of X_ij) / w_i - 1 as measured, by weight
  std::uint64_t bus_down_bytes = 0, bus_up_bytes = 0;
  Picoseconds board_time = 0;  // simulated, of all its pairs
  double host_seconds = 0;     // wall clock, of the whole solution
};

// `standard_error`: one sigma of the sum of `incident` over channels, in its units, from the spread of the samples of a
// leaf's own and its ancestors' links, which are treated as independent.
struct RadiosityResult {
  std::vector<Leaf> leaves;
  std::vector<Power> incident;  // H by leaf
  std::vector<Power> outgoing;  // B by leaf
  std::vector<double> standard_error;
  std::vector<Cluster> clusters;
  std::vector<Link> links;
  RadiosityStatistics statistics;
};

// The current step, and its completed share (0..1).
using RadiosityProgress = std::function<void(std::string_view what, double share)>;

// Loads its own volume onto the board (solids as opaque tags, the medium's extinction as density) and sets its transfer
// functions; load yours again for pictures. `setup` must still have its voxels. Throws InputError with the field's name
// (settings, an emission below 0, a volume too large for the board, a scene without elements or emission), and what
// Board throws.
RadiosityResult solve_radiosity(Board& board, const SceneSetup& setup, const Emissions& emissions,
                                const RadiositySettings& settings, const RadiosityProgress& progress = {});

// Writes FILE in Matrix Market format, coordinate real symmetric: X between clusters, one entry per link, in smallest
// voxel edges squared; a form factor is X_ij / w_i. A factor per cluster scales them, so that they stay symmetric and
// the sum of each element (its own row and its ancestors') closes within 1e-4, or as far as possible; a comment in FILE
// has the remaining error. FILE.clusters.csv has for each row, from 1: facing, tag, box in voxels, area or volume,
// weight, first and last leaf, and the row of the parent cluster. Throws FileError.
void write_factors(const RadiosityResult& result, const std::filesystem::path& file);
std::filesystem::path clusters_file(const std::filesystem::path& file);  // of the clusters' rows

// Writes a line of CSV for each leaf: its open voxel, facing, tag, weight, incident light per unit of weight, and the
// standard error of its sum over channels. Throws FileError.
void write_elements(const RadiosityResult& result, const std::filesystem::path& file);

}  // namespace gicube::samples
