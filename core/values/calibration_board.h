// The printed calibration board under the figure: a chessboard whose white squares hold markers.
// `capture` prints and detects it, `sfm` takes its scale from it, and `synth` renders it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace keypose {

/// A ChArUco board with OpenCV's dictionary DICT_5X5_100, in the plane z = 0. Its centre is the
/// world's origin. Seen from above, with the first marker's corner at the top left, x points right,
/// y points up and z points to the viewer. The defaults fit on an A4 sheet.
struct BoardLayout {
  int columns = 11, rows = 8;                 ///< squares
  double square_m = 0.022;                    ///< side of a square
  double marker_m = kMarkerShare * square_m;  ///< side of a marker with its black border

  static constexpr double kMarkerShare = 0.75;

  double Width() const { return columns * square_m; }
  double Height() const { return rows * square_m; }
  int MarkerCount() const { return columns * rows / 2; }
  int CornerCount() const { return (columns - 1) * (rows - 1); }
  /// Position [m] of the inner chessboard corner with OpenCV's id `id`. Ids run along x first, from
  /// the top row down.
  Eigen::Vector3d Corner(int id) const;
  /// One sentence for each fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// A corner of the board in a photograph. Pixel centres lie at .5.
struct BoardCorner {
  int id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

}  // namespace keypose
