// The first estimate of a camera before a character in one picture: by clicks, else by features,
// else by the outlines of a matte.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "composite/locating/refinement/refine_placement.h"
#include "views/placement/surface_features.h"

namespace keypose::composite {

/// One picture of the character.
struct LocateFrame {
  std::string name;  ///< for messages
  Image8 picture;    ///< RGB
  Image8 matte;      ///< 1 channel of its size, or empty
  double matte_deviation_px = 0.6;
  std::vector<Click> clicks;  ///< none, or some pairs of pixel and place on the mesh
  int pose = 0;               ///< index of the mesh that it shows
  double time = 0;            ///< its number on the film's clock
};

/// What is known of the character's look. Null: nothing.
struct Look {
  const GreyTexture* texture = nullptr;
  const SurfaceFeatures* features = nullptr;
};

/// The mesh in one pose, fine and rough.
struct PosedFigure {
  Figure fine;
  PosedFigure(const PointsX3& points, const FacesX3& faces) : fine(points, faces) {}
  /// Made at the first call, which must not be made in several threads at a time.
  const Figure& rough() const;

 private:
  mutable std::unique_ptr<Figure> rough_;
};

struct FoundPlace {
  Placement at;
  std::string method;  ///< "clicks", "features" or "outlines"
  std::vector<Sighting> sightings;
  /// Mean distance of the outlines at 480 px of the best place that is seen from elsewhere, over
  /// that of this one; 0: no other was tried.
  double rival_ratio = 0;
  /// Smaller is better: px by which outlines differ at 960 px, and what grey values add; 0: not
  /// compared.
  double score = 0;
};

/// @param camera  its focal length is a start
/// @param focal_known  else other focal lengths are tried too
/// @param before  where the frame before had the figure, a further start; null: none
/// @throws InputError  nothing agrees; clicks that do not agree; neither clicks, features nor matte
/// Same bits for any thread count.
FoundPlace FindPlace(const PosedFigure& figure, const LocateFrame& frame, const Look& look,
                     const Camera& camera, bool focal_known, const FoundPlace* before = nullptr);

/// Factors that bring pictures to the sizes of the coarse-to-fine search: 480, 960 pixels and
/// whole.
std::vector<double> SearchScales(int width, int height);

}  // namespace keypose::composite
