// Picks of a person, as constraints of a bent template.
#pragma once

#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "fit/bending/view_constraints.h"

namespace keypose::fit {

/// A pixel of a view that shows a place of the template.
struct PixelPick {
  std::string name;
  SurfacePoint point;
  int view = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of level 0
};

struct BendPicks {
  std::vector<PixelPick> pixels;
  std::vector<LandmarkGoal> places;  ///< in the world's frame
};

/// How a pick agrees with the result, in the order of BendPicks: pixels, then places.
struct PickQuality {
  bool refused = false;  ///< the template cannot be bent there without giving up what views say
  double off = 0;        ///< distance from the pixel's ray, or from the place [length]
  double off_px = 0;     ///< in the picture; 0 for places
};

/// The marks of one template. Each moves with all the vertices of a cell around it, so that it
/// makes no cusp.
class PickConstraints {
 public:
  /// @param rest   V x 3
  /// @param cells  V: which cell of a coarse level each vertex is in
  /// Picks, rest and later positions in one frame.
  PickConstraints(BendPicks marks, const PointsX3& rest, const std::vector<int>& cells);

  /// Pulls of the view's marks towards their rays.
  /// @param weight  of one mark; @param scale  where it has a quarter of it [length]
  void AddPixels(const FitView& view, const PointsX3& points, double weight, double scale,
                 std::vector<Constraint>& constraints) const;
  /// Pulls towards places in space. They come from no view: Constraint::view is -1.
  void AddPlaces(const PointsX3& points, double weight, double scale,
                 std::vector<Constraint>& constraints) const;

  /// @param views  at level 0
  std::vector<PickQuality> Quality(const std::vector<FitView>& views, const PointsX3& points) const;
  /// Refuses, of each name, the mark that is farthest off, if it is farther off than `limit`.
  /// @return whether any was
  bool Refuse(const std::vector<FitView>& views, const PointsX3& points, double limit);
  int count() const { return static_cast<int>(marks_.pixels.size() + marks_.places.size()); }

 private:
  void Pull(const Constraint& of_mark, const SurfacePoint& point,
            std::vector<Constraint>& constraints) const;
  const std::string& NameOf(int mark) const;

  BendPicks marks_;
  PointsX3 rest_;
  std::vector<int> cell_of_;               // V
  std::vector<std::vector<int>> members_;  // of each cell
  std::vector<char> refused_;
};

}  // namespace keypose::fit
