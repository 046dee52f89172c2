// The printed calibration board under the character: a chessboard whose white squares hold markers,
// as capture prints and finds it, sfm measures by it, and synth renders it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace keypose {

/// A ChArUco board of OpenCV's dictionary DICT_5X5_100 in the plane z = 0. Its middle is the
/// world's origin; x to the right and y up when seen from above with the first marker's corner at
/// the top left; z towards the viewer. The defaults fit on a sheet of A4.
struct BoardLayout {
  int columns = 11, rows = 8;                 ///< squares
  double square_m = 0.022;                    ///< side of a square
  double marker_m = kMarkerShare * square_m;  ///< side of a marker with its black border

  static constexpr double kMarkerShare = 0.75;

  double Width() const { return columns * square_m; }
  double Height() const { return rows * square_m; }
  int MarkerCount() const { return columns * rows / 2; }
  int CornerCount() const { return (columns - 1) * (rows - 1); }
  /// Inner chessboard corner of OpenCV's id `id` [m]. Ids run along x first, from the top row down.
  Eigen::Vector3d Corner(int id) const;
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// A corner of the board in a photograph; pixel centres lie at .5.
struct BoardCorner {
  int id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

}  // namespace keypose
