// The cameras of a pose's photographs and the bent template together, by one way or two.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "fit/bending/bend.h"
#include "fit/cameras/find_cameras.h"
#include "fit/cameras/rig_motions.h"
#include "fit/picks/pose_picks.h"

namespace keypose::fit {

/// What the template is bent by.
struct FitInput {
  const Mesh& mesh;
  const Image8& texture;
  const Eigen::VectorXd& stiffness;
  const std::vector<PreparedView>& views;
  const std::vector<View>& rig;
  const PosePicks& picks;
  const Scene& unplaced;
};

/// From where an attempt begins.
struct Start {
  std::vector<FoundCamera> cameras;
  std::optional<RigMotion> on_rig;  ///< nothing: the photographs were not taken from its places
};

/// One set of cameras, and the shape that goes with them.
struct Attempt {
  std::optional<RigMotion> on_rig;  ///< of the start that it comes from
  std::vector<FoundCamera> cameras;
  std::optional<int> late;               ///< cameras found late; nothing if none was looked for
  std::optional<bool> doubtful_dropped;  ///< nothing if there were none
  std::vector<BendView> placed;
  BendPicks marks;
  BendResult result;

  /// Of the outlines, mean of the photographs that were placed.
  double Overlap() const;
  /// Of all photographs; one that was not placed counts as one that hardly agrees. Negative without
  /// a result.
  double Agreement() const;
};

/// Where a prepared view shows a pixel of its photograph.
Eigen::Vector2d PreparedPixel(const PreparedView& view, const Scene& scene,
                              const Eigen::Vector2d& pixel);

/// The picks in photographs that were placed, and those in space.
/// @param lost  if given: receives those in other photographs
BendPicks MarksOf(const PosePicks& picks, const std::vector<BendView>& views, const Scene& scene,
                  std::vector<std::string>* lost);

/// The starts that are worth a try: the figure's likely motions on the rig (FindRigMotions), and
/// each camera by itself where no motion is clear.
std::vector<Start> StartsOf(const std::vector<RigMotion>& motions, const std::vector<View>& rig,
                            const std::vector<FoundCamera>& cameras);

/// Further starts, from cameras that were looked for on all sides (FindCamerasAround).
/// @param tried  starts that are not worth a second try
std::vector<Start> StartsAround(const FitInput& in, const std::vector<FoundCamera>& around,
                                const std::vector<Start>& tried);

/// Bends the template to the photographs whose cameras were found, from each start; the outlines
/// tell which is right. On the rig, the figure is moved there first, and the rig's cameras hold.
/// Without a rig they are solved for together with the shape, and again from the sure ones alone,
/// which then hold: a camera of a part that bent away pulls all others with it.
/// @param before  what other starts gave, to be beaten
/// @return without a result if fewer than two photographs are placed
Attempt FitPose(const FitInput& in, const std::vector<Start>& starts, Progress* progress,
                std::optional<Attempt> before = {});

/// Cameras that were found one by one, looked for again on the shape that they gave, and the
/// template bent once more from there, as long as that agrees better. An attempt on the rig stays.
Attempt FitAgain(const FitInput& in, Attempt attempt, Progress* progress);

}  // namespace keypose::fit
