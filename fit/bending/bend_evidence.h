// What calibrated views say about a template that stands near where they show it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/surfaces/face_pairs.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"
#include "fit/appearance/grey_pyramid.h"
#include "fit/appearance/textured_render.h"
#include "fit/bending/bend_input.h"
#include "fit/bending/pick_constraints.h"
#include "fit/bending/schedule.h"

namespace keypose::fit {

/// The template before it is bent, moved to its middle; lengths in half its diagonals.
struct RestShape {
  const Mesh& mesh;
  PointsX3 points = {};               ///< V x 3
  Eigen::VectorXd vertex_areas = {};  ///< V, over the whole area
  FacePairs pairs = {};
  double area = 0, edge = 0;         ///< the whole area; the mean distance between neighbours
  std::vector<int> cell_of = {};     ///< V: which vertex of the coarse level each goes with
  std::vector<char> of_middle = {};  ///< V: whether the middle level has it
};

/// Where the template stands in one round.
struct BentShape {
  /// @param visible  whether silhouettes or grey values are looked for
  BentShape(PointsX3 at, const FacesX3& faces, bool visible);

  PointsX3 points;  ///< V x 3
  PointsX3 normals;
  std::optional<RayScene> scene;
};

/// What one view gives in one round.
struct BendEvidence {
  std::vector<Constraint> constraints;
  std::vector<int> held;  ///< vertices with a patch
  Eigen::VectorXd sure;   ///< V, confidence of the patch
  Rigid3 pose;            ///< of the camera, improved by texture
  double gap_px = 0, correlation = 0;
  double overlap = 0;  ///< of the render with the mask: intersection over union
};

/// Weight of the shape in a round.
double SurfaceWeight(const Round& round);
/// Weight of one pick in a round.
double MarkWeight(const Round& round, const BendOptions& options);

/// All views of one pose. `Of` may be called from several threads at once.
class ViewEvidence {
 public:
  /// Everything given must outlive it.
  /// @param first_poses  of the cameras, in the frame of the rest shape
  ViewEvidence(const RestShape& rest, const SurfaceTexture& texture,
               const std::vector<BendView>& views, const BendOptions& options,
               std::vector<Rigid3> first_poses);

  /// Vertices that stand nearly right: from now on features are matched with them close by only.
  /// @param placed  V: 1 for these
  void HoldNear(const std::vector<char>& placed) { placed_ = placed; }
  /// Looks for features again, now that the mesh is near, and takes them in place of the first.
  void MatchAgain(const BentShape& shape, const std::vector<Rigid3>& poses, double reach);
  /// Features, marks, outlines and grey values of one view, as the round asks.
  BendEvidence Of(int view, const Round& round, const BentShape& shape, const Rigid3& pose,
                  const PickConstraints& marks) const;
  /// @param pyramid  level of the view; the last one where it has fewer
  FitView ViewAt(int view, int pyramid, const Rigid3& pose) const;
  /// Features in use.
  int matches(int view) const { return static_cast<int>(pictures_[view].matches.size()); }

 private:
  struct Picture {
    GreyPyramid grey;
    std::vector<Outline> outlines;  // by pyramid level
    PictureFeatures features;
    std::vector<FeatureMatch> matches;  // that can be true together
    double noise = 1;
  };

  Picture PictureOf(int view) const;
  std::vector<FeatureMatch> PatchMatches(int view, const BentShape& shape, const Rigid3& pose,
                                         double reach) const;
  TexturedRender RenderIn(const FitView& view, const BentShape& shape) const;
  void AddFeatures(const FitView& at, const Round& round, const BentShape& shape,
                   BendEvidence& evidence) const;
  void AddOutlines(const FitView& at, const Round& round, const BentShape& shape,
                   BendEvidence& evidence) const;
  void AddAppearance(FitView at, const Round& round, const BentShape& shape,
                     BendEvidence& evidence) const;
  void ImprovePose(const std::vector<SeenVertex>& seen, const BentShape& shape, FitView& at,
                   std::vector<PatchShift>& shifts, BendEvidence& evidence) const;
  int LevelIn(int view, int pyramid) const;
  void DropFar(const FitView& at, const BentShape& shape, std::vector<FeatureMatch>& matches) const;

  const RestShape& rest_;
  const SurfaceTexture& texture_;
  const std::vector<BendView>& views_;
  const BendOptions& options_;
  const std::vector<Rigid3> first_poses_;
  std::vector<Picture> pictures_;
  std::vector<char> placed_;  // V, or empty
};

}  // namespace keypose::fit
