// How far the print that a figure stands on is turned in each photograph against the others, seen
// from above.
//
// A printed mat with a scale looks alike after each turn by a tick. Matches of its ticks agree
// with each other at wrong turns, and cameras that were placed by them are wrong together, round
// the mat's middle, where no pair of photographs contradicts them. Drawn from above by its camera,
// each photograph shows the whole print, with its numbers and words, which only one turn brings
// onto those of another.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "reconstruct/surroundings/support_plane.h"

namespace keypose::reconstruct {

struct PrintTurnOptions {
  double radius = 0.3;  ///< of the cameras' distance: so much around the foot is drawn
  int cells = 192;      ///< of the picture from above, along both axes
  int window = 5;       ///< cells to each side whose mean and contrast are taken away
  int angles = 512;     ///< of a turn
  int rings = 72;       ///< of the disc
  double least = 0.12;  ///< correlation of two photographs that says anything
  /// a view is turned where none correlates less than this share of what the best turn does: some
  /// prints look nearly alike when they are turned by a half
  double clearly = 0.6;
  /// [rad] turns of two photographs against each other that are not looked at: what does not turn
  /// with the print, a shadow or what stands on it, goes with itself where they are not turned
  double unturned = 0;
  double enough = 0.02;  ///< and the best turn correlates by so much more than `least`, in the mean
};

struct PrintTurns {
  /// [rad], about the plane's normal, by view: what its camera must be turned by, round the print's
  /// middle, to agree with most; 0 where nothing is known
  std::vector<double> turn;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< on the plane
  std::vector<char> knows;  ///< by view: its print correlates with others at some turn
};

/// What stands on the plane, where the scene's points are, is left out.
/// @param pictures  RGB, by view, of any size
/// @param regions   by view: 255 where what carries the figure may be seen; empty: everywhere
/// Same bits for any thread count.
PrintTurns FindPrintTurns(const Scene& scene, const std::vector<Image8>& pictures,
                          const std::vector<Image8>& regions, const SupportPlane& plane,
                          const PrintTurnOptions& options = {});

/// The view as its camera is when it is turned with the print.
View TurnedWithPrint(const View& view, double turn, const Eigen::Vector3d& normal,
                     const Eigen::Vector3d& middle);

}  // namespace keypose::reconstruct
