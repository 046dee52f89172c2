// How well a registered mesh lies on its target, how much it had to bend, and where one more
// landmark would help.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"
#include "core/ray_scene.h"

namespace keypose::registration {

/// How faces change from source to registered: singular values of each face's map, over the
/// registration's overall scale (the square root of the ratio of areas), so that a change of size
/// alone is no stretch. Quantiles by source area; faces without area are left out.
struct Stretch {
  double low = 1, median = 1, high = 1;  ///< 1 %, 50 % and 99 % quantile of all singular values
  double smallest = 1, largest = 1;
  double worst_ratio = 1;  ///< largest ratio of the two singular values of a face, at most 1e6
};

/// Distances are over the target's bounding diagonal.
struct RegistrationQuality {
  /// faces whose normal points away (dot < 0) from that of the target face with the nearest centre;
  /// in a narrow crease that face may be of the opposite wall
  int flipped = 0;
  /// of these, faces whose normal points away from those of all target faces with centres at most
  /// 0.002 farther than the nearest
  int flipped_clearly = 0;
  int degenerate = 0;  ///< faces that shrank below 1 % of their area in the source
  /// root mean square of exact distances of area samples, both ways together
  double surface_rms = 0;
  double surface_mean = 0;  ///< mean of the two ways' means
  double hausdorff_to_target = 0,
         hausdorff_from_target = 0;  ///< largest distance of samples and vertices
  double coverage = 0;  ///< share of the target's area whose nearest registered point is within 1 %
                        ///< of the diagonal and faces the same way
  std::int64_t self_intersections = 0;  ///< pairs of faces, see self_intersections.h
  /// that count minus the source's own; negative when the source had more
  std::int64_t self_intersections_gained = 0;
  Stretch stretch;
};

/// A result and its target, ready for closest points; made once for all who judge.
struct ResultSurfaces {
  RayScene target, registered;
};
/// @throws InputError  unusable mesh, or `registered` has not the source's vertices
ResultSurfaces MakeResultSurfaces(const Mesh& source, const PointsX3& registered,
                                  const Mesh& target);

/// @throws InputError  unusable mesh
/// Deterministic; 6,000 stratified area samples a way and all vertices.
RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered,
                                        const Mesh& target);
/// @param surfaces  of the same meshes
RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered,
                                        const Mesh& target, const ResultSurfaces& surfaces);

/// Stretch alone; cheap.
Stretch MeasureStretch(const Mesh& source, const PointsX3& registered);

/// A place on the source where one more landmark would help.
struct LandmarkAdvice {
  int vertex = -1;                                       ///< of the source
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< of that vertex in the source
  Eigen::Vector3d registered = Eigen::Vector3d::Zero();  ///< where it came to lie
  /// mean distance to the target (and back) around it, over the target's diagonal
  double misfit = 0;
  double landmark_distance = 0;  ///< along the source's surface to the nearest landmark, over its
                                 ///< diagonal; infinite without landmarks
  double stretch = 1;  ///< largest factor, longer or shorter, by which a face around it changed
  double score = 0;    ///< larger is more needed; comparable within one mesh
  std::string reason;  ///< one sentence
};

/// The places where the result is least certain, worst first, far from each other and from the
/// landmarks that there are: misfit, stretch and flips around a vertex, weighed up with the
/// distance along the surface to the nearest landmark and with how far out on a limb it lies. Of
/// more than 200,000 faces, about so many are looked at.
/// @param count  at most this many; fewer where nothing is wrong or the mesh is small
/// @throws InputError  unusable mesh
/// Deterministic.
std::vector<LandmarkAdvice> AdviseLandmarks(const Mesh& source, const PointsX3& registered,
                                            const Mesh& target,
                                            const std::vector<LandmarkGoal>& landmarks,
                                            int count = 3);
/// @param surfaces  of the same meshes
std::vector<LandmarkAdvice> AdviseLandmarks(const Mesh& source, const PointsX3& registered,
                                            const Mesh& target,
                                            const std::vector<LandmarkGoal>& landmarks,
                                            const ResultSurfaces& surfaces, int count = 3);

}  // namespace keypose::registration
