// Where a mesh may be seen from, by the shape of its matte alone.
#pragma once

#include <vector>

#include "composite/locating/outline/mesh_silhouette.h"

namespace keypose::composite {

struct ShapeCandidate {
  Rigid3 camera_from_mesh;
  double overlap = 0;  ///< of the two shapes, moved and scaled onto each other
};

/// The silhouettes of one mesh from all sides, for the search of many mattes.
class ShapeSearch {
 public:
  /// @param angular_radius  about that of the figure in the pictures [rad]: the square root of its
  /// solid angle over pi. Perspective depends on it.
  /// Cost: a drawing of 64 x 64 rays for each of about 800 directions.
  /// Same bits for any thread count.
  ShapeSearch(const Figure& figure, double angular_radius);

  /// The best places, at least 12 degrees apart, best first.
  ///
  /// Shapes are compared as drawings in polar coordinates about their centroids, with the root of
  /// their area as unit of length: a turn of the camera about its axis shifts a drawing.
  /// @param matte  1 channel, of the camera's size; may be much smaller than the photograph
  /// @return none when the matte is empty
  std::vector<ShapeCandidate> Find(const Camera& camera, const Image8& matte, int most) const;

 private:
  struct Drawing {
    Rigid3 camera_from_mesh;
    Eigen::VectorXf cells;  ///< weighted occupancy, radius after radius
    Eigen::Vector2d centroid;
    double radius = 0, squares = 0;
  };
  const Figure& figure_;
  std::vector<Drawing> drawings_;
};

/// The square root of a matte's solid angle over pi [rad]; 0 when it is empty.
double AngularRadius(const Camera& camera, const Image8& matte);

}  // namespace keypose::composite
