#include "capture/room/asked_views.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/numbers/statistics.h"
#include "core/pictures/image_turns.h"

namespace keypose::capture {
namespace {

constexpr double kNotTooNear = 0.8;  // of the median distance to the middle
constexpr double kInMiddle = 0.35;   // of the longer side: the middle's distance from the picture's
constexpr double kNextToNothing = 0.005;  // of the picture
constexpr int kSure = 200;                // of the network's 255

Image8 Turned(const Image8& image, int quarters) {
  Image8 turned = quarters >= 2 ? TurnedOver(image) : image;
  return quarters % 2 == 1 ? QuarterTurned(turned) : turned;
}

/// Whether a view shows the middle near its own, from not too near.
std::vector<char> ShowItWhole(const std::vector<View>& views, const Eigen::Vector3d& middle) {
  std::vector<double> distances;
  for (const View& view : views) distances.push_back((view.Center() - middle).norm());
  const double usual = UpperMedian(distances);
  std::vector<char> whole(views.size(), 0);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Camera& camera = views[v].camera;
    const Eigen::Vector2d off =
        views[v].Project(middle) - Eigen::Vector2d(camera.width, camera.height) / 2;
    whole[v] = distances[v] >= kNotTooNear * usual &&
               off.norm() < kInMiddle * std::max(camera.width, camera.height);
  }
  if (std::count(whole.begin(), whole.end(), 1) < 3) whole.assign(views.size(), 1);
  return whole;
}

double SureShare(const Image8& salience) {
  const auto sure = std::count_if(salience.data.begin(), salience.data.end(),
                                  [](std::uint8_t s) { return s > kSure; });
  return static_cast<double>(sure) / static_cast<double>(salience.data.size());
}

}  // namespace

std::vector<int> ViewsToAsk(const std::vector<View>& views, const Eigen::Vector3d& middle,
                            int count, const std::vector<int>& first) {
  const std::vector<char> whole = ShowItWhole(views, middle);
  std::vector<Eigen::Vector3d> directions;
  for (const View& view : views) directions.push_back((view.Center() - middle).normalized());
  std::vector<int> asked = first;
  if (asked.empty())
    asked.push_back(static_cast<int>(std::find(whole.begin(), whole.end(), 1) - whole.begin()));
  while (static_cast<int>(asked.size()) < count) {
    int best = -1;
    double farthest = 1 - 1e-9;  // the largest cosine to those that are asked, as small as possible
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (!whole[v]) continue;
      double nearest = -1;
      for (const int a : asked)
        nearest = std::max(nearest, directions[v].dot(directions[static_cast<std::size_t>(a)]));
      if (nearest >= farthest) continue;
      farthest = nearest;
      best = static_cast<int>(v);
    }
    if (best < 0) break;
    asked.push_back(best);
  }
  return asked;
}

int TurnsToUpright(const View& view, const Eigen::Vector3d& middle) {
  const double step = 0.05 * (view.Center() - middle).norm();
  const Eigen::Vector2d up =
      view.Project(middle + Eigen::Vector3d(0, 0, step)) - view.Project(middle);
  if (std::abs(up.y()) >= std::abs(up.x())) return up.y() <= 0 ? 0 : 2;
  return up.x() < 0 ? 1 : 3;  // what points left points up after a turn clockwise
}

Image8 AskUpright(const Salience& salience, const Image8& rgb, int turns) {
  const Image8 upright = Turned(rgb, turns);
  Image8 seen = salience(upright, false);
  if (SureShare(seen) < kNextToNothing) seen = salience(upright, true);
  return Turned(seen, (4 - turns) % 4);
}

}  // namespace keypose::capture
