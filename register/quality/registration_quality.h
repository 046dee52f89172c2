// How well a registered mesh fits its target, how much it was stretched, and where one more
// landmark would help.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// How faces change from source to registered: the singular values of each face's map. They are
/// divided by the overall scale (the square root of the ratio of areas), so that a change of size
/// alone is no stretch. Quantiles are weighted by source area. Faces without area are left out.
struct Stretch {
  double low = 1, median = 1, high = 1;  ///< 1 %, 50 % and 99 % quantiles of all singular values
  double smallest = 1, largest = 1;
  double worst_ratio = 1;  ///< largest ratio of the two singular values of a face, at most 1e6
};

/// Distances are over the target's bounding diagonal.
struct RegistrationQuality {
  /// Faces whose normal opposes (dot < 0) that of the target face with the nearest centre. In a
  /// narrow crease that face may belong to the opposite wall.
  int flipped = 0;
  /// Of these, faces whose normal opposes those of all target faces whose centres are at most 0.002
  /// farther than the nearest
  int flipped_clearly = 0;
  int degenerate = 0;  ///< faces with less than 1 % of their area in the source
  /// root mean square of exact distances of area samples, both ways together
  double surface_rms = 0;
  double surface_mean = 0;  ///< mean of the two ways' means
  double hausdorff_to_target = 0,
         hausdorff_from_target = 0;  ///< largest distance of samples and vertices, for each way
  double coverage = 0;  ///< share of the target's area whose nearest registered point is within 1 %
                        ///< of the diagonal and faces the same way
  std::int64_t self_intersections = 0;  ///< pairs of faces, see self_intersections.h
  /// that count minus the source's own; negative when the source had more
  std::int64_t self_intersections_gained = 0;
  Stretch stretch;
};

/// A result and its target with search structures for closest points. Built once and shared by all
/// measures.
struct ResultSurfaces {
  RayScene target, registered;
};
/// @throws InputError  unusable mesh, or `registered` does not have the source's vertex count
ResultSurfaces MakeResultSurfaces(const Mesh& source, const PointsX3& registered,
                                  const Mesh& target);

/// Measures a result, with 6,000 stratified area samples for each way and all vertices.
/// @throws InputError  unusable mesh
/// Deterministic.
RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered,
                                        const Mesh& target);
/// @param surfaces  of the same meshes
RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered,
                                        const Mesh& target, const ResultSurfaces& surfaces);

/// The stretch alone, which is fast.
Stretch MeasureStretch(const Mesh& source, const PointsX3& registered);

/// A place on the source where one more landmark would help.
struct LandmarkAdvice {
  int vertex = -1;                                       ///< of the source
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< of that vertex in the source
  Eigen::Vector3d registered = Eigen::Vector3d::Zero();  ///< of that vertex in the result
  /// mean distance to the target (and back) around it, over the target's diagonal
  double misfit = 0;
  double landmark_distance = 0;  ///< along the source's surface to the nearest landmark, or to a
                                 ///< place advised before, over its diagonal; infinite without any
  double stretch = 1;  ///< geometric mean of the factors by which the faces around it changed
  double score = 0;    ///< higher means more needed; comparable within one mesh
  std::string reason;  ///< one sentence
};

/// Places where the result is least certain, worst first. They are far from each other and from the
/// existing landmarks. The score combines misfit, stretch and flipped faces around a vertex with
/// its distance along the surface to the nearest landmark, and is higher at the ends of limbs.
/// On a mesh of more than 200,000 faces, about that many are measured.
/// @param count  most places; fewer when little is wrong or the mesh is small
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
