// The plan step of filtered backprojection: from a target to the views that are used (each, each second, ...), the rays
// a pixel and their step.
//
// A pilot is the same reconstruction of a slab around the middle plane. That of the finest setting (all views, one ray
// a pixel along each axis more than asked for, half a voxel) is compared with others: first each coarser one alone,
// then combinations, cheapest first. The cheapest of all that are good enough is chosen. Two and six of its views tell
// what settings cost in the whole volume; for a time budget the chosen one is reconstructed, and another one taken if
// it misses the budget. "Error" is the root of the mean square difference over that of the finest setting's values, of
// the voxels that all views see.
#pragma once

#include <string>
#include <vector>

#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "gicube/plan_text.h"

namespace gicube::samples {

struct FdkPlanPoint {
  int every = 1;  // which views: each so many'th
  int rays = 1;
  double step = 1;
  double error = 0, error_bound = 0;  // as found in the pilot; see plan.cpp
  double deposits = 0;                // predicted, of the whole volume
  Picoseconds time = 0;               // predicted, of the board; FdkPlan::chosen's for a budget was simulated
};

struct FdkPlan {
  FdkPlanPoint chosen, finest;
  bool kept = true;                  // false: nothing reaches the target, and `chosen` is what comes nearest
  std::vector<FdkPlanPoint> points;  // every pilot, in that order
  std::size_t views = 0;             // of the scan
  int slices = 0;                    // of a pilot
  FieldOfView field;                 // that all views see, as far as the volume goes
  int pilots = 0;
  double pilot_deposits = 0;
  double host_seconds = 0;
  PlanTarget target;

  FdkSettings settings(const FdkSettings& original) const;
  std::vector<std::string> explain() const;  // lines for people
};

// `settings`: what is not chosen; its rays are the least that leave no voxels out. Throws BadArgument (one of both
// targets; geometry, projections, settings), what the board throws. The boards' volumes are lost.
// `timed`: the board whose time counts, if pilots are made by another one (a functional board has the same bits much
// sooner).
FdkPlan plan_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                 const FdkSettings& settings, const PlanTarget& target, const Progress& progress = {},
                 Board* timed = nullptr);

// Each `every`th view alone.
ConeGeometry some_views(const ConeGeometry& geometry, int every);
Projections some_views(const Projections& projections, std::size_t views, int every);

// The voxels that every view sees.
FieldOfView field_seen(const ConeGeometry& geometry, bool displaced = false);

// Strides at which views may be kept so that they remain evenly spread, for a short scan from the first to the last.
// Ascending, from 2.
std::vector<int> strides_of(const ConeGeometry& geometry, int max_stride);

// Some slices around the middle plane, and the detector's rows whose rays run through them.
struct Slab {
  ConeGeometry geometry;
  Projections projections;
};
Slab slab_of(const ConeGeometry& geometry, const Projections& projections, int slices);

}  // namespace gicube::samples
