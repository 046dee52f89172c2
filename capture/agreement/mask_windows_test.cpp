// A slab with a window, photographed from all round in front of a grey backdrop; all masks have
// filled the window.
#include "capture/agreement/mask_windows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/testing/test_images.h"
#include "core/numbers/parallel.h"

namespace keypose::capture::windows_test {

constexpr int kWidth = 200, kHeight = 160, kViews = 24;
constexpr double kFocal = 240, kDistance = 4;
constexpr std::array<std::uint8_t, 3> kGrey{176, 176, 178}, kTeal{40, 130, 120};

/// The slab is in the plane of y and z: half of its sides, and of its window's.
const Eigen::Vector3d kSlab{0.12, 0.8, 0.7}, kWindow{0.12, 0.3, 0.3};

View RingView(int i) {
  return MakeTestView(i, kViews, kDistance, i % 2 ? 0.5 : 0.1, kWidth, kHeight, kFocal);
}

/// Whether a point of the slab blocks a ray, with or without the window. `at` is set to the first
/// hit.
bool Hits(const Eigen::Vector3d& from, const Eigen::Vector3d& ray, bool with_window,
          Eigen::Vector3d* at) {
  for (double t = kDistance - 1.3; t < kDistance + 1.3; t += 0.01) {
    const Eigen::Vector3d x = from + t * ray;
    if ((x.array().abs() > kSlab.array()).any()) continue;
    if (with_window && (x.array().abs() <= kWindow.array()).all()) continue;
    *at = x;
    return true;
  }
  return false;
}

struct Set {
  std::vector<View> views;
  std::vector<Image8> images, filled;
  std::vector<std::vector<char>> hole;  ///< pixels through which the window shows the backdrop
  std::vector<Backdrop> backdrops;
};

/// @param open  whether the window is open, or painted with the backdrop's grey on one side
Set MakeSet(bool open) {
  Set set;
  Image8 empty(kWidth, kHeight, 3);
  for (std::size_t i = 0; i < empty.data.size(); ++i) empty.data[i] = kGrey[i % 3];
  for (int i = 0; i < kViews; ++i) {
    const View view = RingView(i);
    Image8 image = empty, filled(kWidth, kHeight, 1, 0);
    std::vector<char> hole(static_cast<std::size_t>(kWidth) * kHeight, 0);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector3d ray =
            view.camera_from_world.rotation.conjugate() *
            view.camera.Unproject(Eigen::Vector2d(x + 0.5, y + 0.5)).normalized();
        Eigen::Vector3d at;
        if (!Hits(view.Center(), ray, false, &at)) continue;
        *filled.at(x, y) = 255;
        const bool painted =
            at.x() > 0.1 && std::abs(at.y()) < kWindow.y() && std::abs(at.z()) < kWindow.z();
        const bool through = open && !Hits(view.Center(), ray, true, &at);
        hole[static_cast<std::size_t>(y) * kWidth + x] = through;
        if (open ? !through : !painted) std::copy(kTeal.begin(), kTeal.end(), image.at(x, y));
      }
    set.views.push_back(view);
    set.images.push_back(std::move(image));
    set.filled.push_back(std::move(filled));
    set.hole.push_back(std::move(hole));
    set.backdrops.push_back({LabOf(empty), {2, 2, 2}, {}});
  }
  return set;
}

const SpaceOptions kCoarse{.resolution = 80};

TEST(OpenWindows, OpensWhatOthersSeeThroughThoughAllMasksFilledIt) {
  const Set set = MakeSet(true);
  std::vector<Image8> masks = set.filled;
  EXPECT_GT(OpenWindows(set.images, set.views, set.backdrops, kCoarse, {}, masks), 0.01);
  int right = 0, hole = 0, wrong = 0, figure = 0;
  for (std::size_t i = 0; i < masks.size(); ++i)
    for (std::size_t p = 0; p < masks[i].data.size(); ++p) {
      const bool opened = set.filled[i].data[p] && !masks[i].data[p];
      hole += set.hole[i][p], right += opened && set.hole[i][p];
      figure += set.filled[i].data[p] && !set.hole[i][p], wrong += opened && !set.hole[i][p];
    }
  EXPECT_GT(right, 0.9 * hole);     // narrow slits at grazing views remain
  EXPECT_LT(wrong, 0.02 * figure);  // a pixel round each
}

TEST(OpenWindows, LeavesWhatIsPaintedInTheBackdropsColor) {
  const Set set = MakeSet(false);
  std::vector<Image8> masks = set.filled;
  EXPECT_EQ(OpenWindows(set.images, set.views, set.backdrops, kCoarse, {}, masks), 0);
}

TEST(OpenWindows, AsksOnlyInliers) {
  const Set set = MakeSet(true);
  std::vector<char> inlier(set.views.size(), 1);
  inlier[0] = 0;
  std::vector<Image8> masks = set.filled;
  OpenWindows(set.images, set.views, set.backdrops, kCoarse, inlier, masks);
  EXPECT_EQ(masks[0].data, set.filled[0].data);
  EXPECT_NE(masks[1].data, set.filled[1].data);
}

TEST(OpenWindows, SameBitsForAnyThreadCount) {
  const Set set = MakeSet(true);
  std::vector<Image8> once = set.filled, again = set.filled;
  SetThreadCount(1);
  OpenWindows(set.images, set.views, set.backdrops, kCoarse, {}, once);
  SetThreadCount(3);
  OpenWindows(set.images, set.views, set.backdrops, kCoarse, {}, again);
  SetThreadCount(0);
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_EQ(once[i].data, again[i].data);
}

}  // namespace keypose::capture::windows_test
