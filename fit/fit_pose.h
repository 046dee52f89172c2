// The cameras of a pose's photographs and the bent template together, by one way or two.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "fit/bending/bend.h"
#include "fit/cameras/find_cameras.h"
#include "fit/picks/pose_picks.h"

namespace keypose::fit {

/// What the template is bent by.
struct FitInput {
  const Mesh& mesh;
  const Image8& texture;
  const Eigen::VectorXd& stiffness;
  const std::vector<PreparedView>& views;
  std::vector<View> rig;  ///< empty: the photographs were not taken from its places
  const PosePicks& picks;
  const Scene& unplaced;
};

/// One set of cameras, and the shape that goes with them.
struct Attempt {
  std::vector<FoundCamera> cameras;
  std::optional<int> late;               ///< cameras found late; nothing if none was looked for
  std::optional<bool> doubtful_dropped;  ///< nothing if there were none
  std::vector<BendView> placed;
  BendMarks marks;
  BendResult result;

  double Overlap() const {
    double sum = 0;
    for (const ViewQuality& view : result.view_quality) sum += view.overlap;
    return sum / std::max(1, SizeOf(result.view_quality));
  }
};

/// Where a prepared view shows a pixel of its photograph.
Eigen::Vector2d PreparedPixel(const PreparedView& view, const Scene& scene,
                              const Eigen::Vector2d& pixel);

/// The picks in photographs that were placed, and those in space.
/// @param lost  if given: receives those in other photographs
BendMarks MarksOf(const PosePicks& picks, const std::vector<BendView>& views, const Scene& scene,
                  std::vector<std::string>* lost);

/// Bends the template to the photographs whose cameras were found. The rig's cameras (`in.rig`)
/// hold; without a rig they are solved for together with the shape, and again from the sure ones
/// alone, which then hold: a camera of a part that bent away pulls all others with it. The outlines
/// tell which is right.
/// @param by_rig  whether the cameras are places of the rig
/// @return without a result if fewer than two photographs are placed
Attempt FitPose(const FitInput& in, const std::vector<FoundCamera>& cameras, bool by_rig,
                Progress* progress);

}  // namespace keypose::fit
