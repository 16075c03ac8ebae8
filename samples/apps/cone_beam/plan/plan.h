// The plan step of filtered backprojection: chooses the stride of the used views, the rays per pixel and their step for
// a target.
//
// A pilot is the same reconstruction of a slab around the middle plane. The planner compares pilots with that of the
// finest setting (all views, one ray per pixel along each axis more than asked for, half a voxel): first those that are
// coarser in one parameter, then combinations, cheapest first. It chooses the cheapest setting that is good enough.
// Runs of two and of six views give the cost in the whole volume. For a time budget, it reconstructs the whole volume
// with the chosen setting, and chooses another one if that misses the budget. "Error" is the root of the mean square
// difference relative to that of the finest setting's values, over the voxels that all views see.
#pragma once

#include <string>
#include <vector>

#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "gicube/plan_text.h"

namespace gicube::samples {

struct FdkPlanPoint {
  int every = 1;  // stride of the views
  int rays = 1;
  double step = 1;
  double error = 0, error_bound = 0;  // in the pilot; see plan.cpp
  double deposits = 0;                // predicted, of the whole volume
  Picoseconds time = 0;               // predicted, of the board; simulated for FdkPlan::chosen with a budget
};

struct FdkPlan {
  FdkPlanPoint chosen, finest;
  bool kept = true;                  // false: no setting reaches the target, and `chosen` is the nearest
  std::vector<FdkPlanPoint> points;  // all pilots, in their order
  std::size_t views = 0;             // of the scan
  int slices = 0;                    // of a pilot
  FieldOfView field;                 // that all views see, inside the volume
  int pilots = 0;
  double pilot_deposits = 0;
  double host_seconds = 0;
  PlanTarget target;

  FdkSettings settings(const FdkSettings& original) const;
  std::vector<std::string> explain() const;  // lines for the user
};

// `settings`: the fixed settings; its rays are the fewest that omit no voxel. `timed`: the board whose time counts, if
// `board` is another one for pilots (a functional board computes the same bits much sooner). Overwrites the boards'
// volumes. Throws BadArgument (not exactly one target; geometry, projections, settings), what the board throws.
FdkPlan plan_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                 const FdkSettings& settings, const PlanTarget& target, const Progress& progress = {},
                 Board* timed = nullptr);

// Each `every`th view.
ConeGeometry some_views(const ConeGeometry& geometry, int every);
Projections some_views(const Projections& projections, std::size_t views, int every);

// The voxels that every view sees.
FieldOfView field_seen(const ConeGeometry& geometry, bool displaced = false);

// Strides that keep the views' distances equal; in a short scan also its first and last view. Ascending, from 2.
std::vector<int> strides_of(const ConeGeometry& geometry, int max_stride);

// A few slices around the middle plane, and the detector's rows with rays through them.
struct Slab {
  ConeGeometry geometry;
  Projections projections;
};
Slab slab_of(const ConeGeometry& geometry, const Projections& projections, int slices);

}  // namespace gicube::samples
