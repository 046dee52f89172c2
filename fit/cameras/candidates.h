// Places from which a photograph may have been taken, and how well each explains it.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "fit/appearance/textured_render.h"
#include "views/placement/surface_features.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

struct Candidate {
  Rigid3 camera_from_world;
  bool free = false;                    ///< of no rig: anywhere
  double overlap = 0;                   ///< of silhouette and mask
  std::vector<FeatureMatch> matches{};  ///< nearby
  std::vector<FeatureMatch> picks{};    ///< nearby, as often as they count
  double score = 0;                     ///< matches, the nearer the more; if free, outlines too

  std::vector<FeatureMatch> MatchesAndPicks() const;
};

/// Those near where the candidate shows their places.
std::vector<FeatureMatch> NearMatches(const Candidate& candidate, const PointsX3& points,
                                      const Pinhole& camera,
                                      const std::vector<FeatureMatch>& matches);

/// Compares a mesh as candidates show it with photographs.
class CandidateJudge {
 public:
  /// @param mesh, texture  must outlive this object; the texture may be empty for Overlaps
  CandidateJudge(const Mesh& mesh, const Image8& texture);

  /// Of the silhouettes under the rig's cameras with the mask, at the coarsest level.
  std::vector<double> Overlaps(const PreparedView& view, const std::vector<View>& rig) const;

  /// The rig's cameras whose silhouettes overlap most with the mask, by falling overlap.
  std::vector<Candidate> OfRig(const PreparedView& view, const std::vector<View>& rig) const;

  /// Cameras all round from which the mesh looks most like the photograph, and the one that most
  /// of `matches` agree with.
  std::vector<Candidate> AllRound(const PreparedView& view,
                                  const std::vector<FeatureMatch>& matches) const;

  /// Renders the mesh as the candidate has it, and matches features near where it shows them.
  /// @param picks  of the photograph, as often as they count; those near it score, too
  void Judge(const PreparedView& view, const PictureFeatures& photo,
             const std::vector<FeatureMatch>& picks, Candidate& candidate) const;

  /// Moves the camera to where the nearby features and picks want it, as long as that makes it
  /// better.
  void Improve(const PreparedView& view, const PictureFeatures& photo,
               const std::vector<FeatureMatch>& picks, Candidate& candidate) const;

 private:
  TexturedRender RenderAt(const PreparedView& view, int level, const Rigid3& pose) const;

  const Mesh& mesh_;
  const Image8& picture_;
  SurfaceTexture texture_;
  RayScene scene_;
  double area_;
};

/// That with the highest score; nothing if there is none.
const Candidate* BestOf(const std::vector<Candidate>& candidates);

/// A photograph's features, as many as candidates are judged by.
PictureFeatures FeaturesToJudgeBy(const PreparedView& view);

/// How far a match may be from where a candidate shows its place.
double Reach(const Pinhole& camera);

}  // namespace keypose::fit
