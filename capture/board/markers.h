// Square markers of a calibration board in a picture.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// The picture in grey, or with dark and bright exchanged.
Image8 GreyPicture(const Image8& image, bool inverted = false);
/// The picture as a mirror shows it, left and right exchanged.
Image8 MirroredPicture(const Image8& grey);

struct SeenMarker {
  int id = 0;
  /// clockwise from the marker's own top left; pixel centres are whole numbers
  std::array<Eigen::Vector2d, 4> corners;
};

/// Markers of a dictionary, as OpenCV finds them.
/// @param thorough  also in a copy of twice the size where the picture is small: webcams show
/// markers of a dozen pixels
/// Source: Garrido-Jurado et al., Pattern Recognition 2014.
std::vector<SeenMarker> FindMarkers(const Image8& grey, int dictionary, bool thorough);

/// What may be a marker of an unknown dictionary.
struct MarkerQuad {
  std::array<Eigen::Vector2d, 4> corners;  ///< clockwise; pixel centres are whole numbers
  double Side() const;                     ///< mean [px]
};

/// Dark convex quadrilaterals on a bright ground.
std::vector<MarkerQuad> FindQuads(const Image8& grey);

/// The quads that are markers of the dictionary, without a wrong bit.
std::vector<SeenMarker> ReadQuads(const Image8& grey, const std::vector<MarkerQuad>& quads,
                                  int dictionary);

}  // namespace keypose::capture
