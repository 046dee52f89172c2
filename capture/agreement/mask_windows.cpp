#include "capture/agreement/mask_windows.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <numeric>

#include "capture/agreement/space_grid.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

// Tuned on the synthetic figure with a hand on its hip and on columns in 16 views
// (docs/decisions/handles-seen-through.md); no record of single values. Sensitivity:
// docs/results/sensitivity.md.
struct WindowTuning {
  // largest remaining thickness along a window's rays, per cent of the hull's longest side
  KEYPOSE_TUNED(int, kThin, 9);
  // largest remaining share of the thickness, for windows with a loose match to the empty set
  KEYPOSE_TUNED(double, kLeft, 0.45);
  // largest scalar product of the directions of views from opposite sides
  KEYPOSE_TUNED(double, kOpposite, -0.6);
  // least share of a window's pixels whose rays another window meets
  KEYPOSE_TUNED(double, kFromBehind, 0.2);
};

struct Window {
  std::size_t view = 0;
  Region pixels;
  bool loose = false;  ///< only a loose match to the empty set
  int thick = 0;       ///< per cent of the hull's longest side, with the initial masks

  bool Through(int left) const {
    return left <= (loose ? std::min<double>(WindowTuning::kThin, WindowTuning::kLeft * thick)
                          : WindowTuning::kThin);
  }
};

std::vector<Window> Candidates(const std::vector<Image8>& images,
                               const std::vector<Backdrop>& backdrops,
                               const std::vector<char>& inlier, const std::vector<Image8>& masks) {
  std::vector<std::vector<Window>> found(images.size());
  ParallelFor(std::ssize(images), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    if (!inlier.empty() && !inlier[i]) return;
    for (const bool loose : {false, true})
      for (Region& region : FindMaskHoles(images[i], backdrops[i], masks[i], loose))
        found[i].push_back({i, std::move(region), loose});
  });
  std::vector<Window> windows;
  for (std::vector<Window>& of : found)
    std::move(of.begin(), of.end(), std::back_inserter(windows));
  return windows;
}

/// The border mixes window and figure, so it is opened as well.
void Open(const Window& window, Image8& mask) {
  for (const std::int32_t at : window.pixels) {
    const int x = at % mask.width, y = at / mask.width;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      if (x + dx >= 0 && y + dy >= 0 && x + dx < mask.width && y + dy < mask.height)
        *mask.at(x + dx, y + dy) = 0;
  }
}

struct Space {
  std::vector<MaskSampler> samplers;
  Grid grid;

  Space(const std::vector<View>& views, const std::vector<Image8>& masks,
        const SpaceOptions& options, const std::vector<char>& inlier)
      : samplers(MaskSamplersOf(views, masks, options, inlier)),
        grid(SharedSpace(views, masks, samplers, options, 1)) {}
};

Eigen::Vector3d RayOf(const View& view, double x, double y) {
  return (view.camera_from_world.rotation.conjugate() * view.camera.Unproject({x, y})).normalized();
}

/// Median over each window's pixels of the remaining thickness with the other views, per cent of
/// the hull's longest side.
std::vector<int> Thicknesses(const Space& space, const std::vector<Window>& windows) {
  const int longest = LongestSide(space.grid);
  std::vector<int> thicknesses(windows.size());
  ParallelFor(std::ssize(windows), [&](std::int64_t k) {
    const Window& window = windows[k];
    const MaskSampler& sampler = space.samplers[window.view];
    std::vector<int> chords;
    for (const std::int32_t at : window.pixels)
      chords.push_back(ChordOf(sampler, at % sampler.contradicted.width,
                               at / sampler.contradicted.width, space.grid, true));
    thicknesses[k] = 100 * UpperMedian(std::move(chords)) / longest;
  });
  return thicknesses;
}

/// Groups windows whose rays meet inside the original hull.
class WindowGroups {
 public:
  WindowGroups(const std::vector<Window>& windows, const Space& filled, const Space& open)
      : filled_(filled), open_(open) {
    labels_.resize(open.samplers.size());
    for (std::size_t k = 0; k < windows.size(); ++k) {
      std::vector<int>& labels = labels_[windows[k].view];
      const Image8& contradicted = open.samplers[windows[k].view].contradicted;
      labels.resize(contradicted.data.size(), -1);
      if (windows[k].thick > WindowTuning::kThin)
        for (const std::int32_t at : windows[k].pixels) labels[at] = static_cast<int>(k);
    }
    group_.resize(windows.size());
    std::iota(group_.begin(), group_.end(), 0);
    std::vector<std::map<int, Count>> met(windows.size());
    ParallelFor(std::ssize(windows), [&](std::int64_t k) {
      if (windows[k].thick > WindowTuning::kThin) met[k] = MetBy(windows[k]);
    });
    for (std::size_t k = 0; k < windows.size(); ++k)
      for (const auto& [other, count] : met[k])
        if (count.pixels >= Enough(windows[k])) group_[Root(static_cast<int>(k))] = Root(other);
    both_sides_.assign(windows.size(), 0);
    for (std::size_t k = 0; k < windows.size(); ++k)
      for (const auto& [other, count] : met[k])
        if (count.opposite >= Enough(windows[k])) both_sides_[Root(static_cast<int>(k))] = 1;
  }

  /// Whether a window, or a window connected with it, is seen from both sides. Paint on one side of
  /// the figure is seen from that side alone, even on a thin figure.
  bool FromBothSides(std::size_t k) const { return both_sides_[Root(static_cast<int>(k))]; }

 private:
  struct Count {
    int pixels = 0, opposite = 0;
  };

  /// A sample of a window's pixels is sufficient.
  static std::size_t Stride(const Window& window) { return window.pixels.size() / 40 + 1; }
  static double Enough(const Window& window) {
    return WindowTuning::kFromBehind *
           static_cast<double>((window.pixels.size() + Stride(window) - 1) / Stride(window));
  }

  int Root(int k) const {
    while (group_[k] != k) k = group_[k];
    return k;
  }

  /// Number of the window's pixels whose rays meet each other window.
  std::map<int, Count> MetBy(const Window& window) const {
    const MaskSampler& own = open_.samplers[window.view];
    const Grid& grid = filled_.grid;
    const Eigen::Vector3d from = own.view->Center(),
                          middle = grid.low + 0.5 * grid.cell * grid.size.cast<double>();
    const double reach = 0.5 * grid.cell * grid.size.cast<double>().norm();
    std::map<int, Count> all;
    for (std::size_t p = 0; p < window.pixels.size(); p += Stride(window)) {
      const std::int32_t at = window.pixels[p];
      const Eigen::Vector3d ray =
          RayOf(*own.view, at % own.contradicted.width + 0.5, at / own.contradicted.width + 0.5);
      const double nearest = ray.dot(middle - from);
      std::map<int, bool> met;  // and whether from behind
      for (double t = nearest - reach; t < nearest + reach; t += grid.cell) {
        const Eigen::Vector3i cell =
            ((from + t * ray - grid.low) / grid.cell).array().floor().cast<int>();
        if ((cell.array() < 0).any() || (cell.array() >= grid.size.array()).any()) continue;
        if (grid.contradictions[grid.At(cell.x(), cell.y(), cell.z())] == 0)
          Meet(window, grid.Center(cell.x(), cell.y(), cell.z()), ray, &met);
      }
      for (const auto& [other, opposite] : met) {
        ++all[other].pixels;
        all[other].opposite += opposite;
      }
    }
    return all;
  }

  void Meet(const Window& window, const Eigen::Vector3d& x, const Eigen::Vector3d& ray,
            std::map<int, bool>* met) const {
    for (std::size_t j = 0; j < open_.samplers.size(); ++j) {
      const MaskSampler& sampler = open_.samplers[j];
      Eigen::Vector3d pixel;
      if (j == window.view || labels_[j].empty() ||
          sampler.At(x, &pixel) != MaskSample::kContradicted)
        continue;
      const int other = labels_[j][static_cast<std::size_t>(pixel.y()) *
                                       static_cast<std::size_t>(sampler.contradicted.width) +
                                   static_cast<std::size_t>(pixel.x())];
      if (other >= 0)
        (*met)[other] |=
            ray.dot((x - sampler.view->Center()).normalized()) < WindowTuning::kOpposite;
    }
  }

  const Space &filled_, &open_;
  std::vector<std::vector<int>> labels_;  // for each view's pixels: index of the window
  std::vector<int> group_;
  std::vector<char> both_sides_;
};

std::vector<Image8> Opened(std::vector<Image8> masks, const std::vector<Window>& windows) {
  for (const Window& window : windows) Open(window, masks[window.view]);
  return masks;
}

}  // namespace

double OpenWindows(const std::vector<Image8>& images, const std::vector<View>& views,
                   const std::vector<Backdrop>& backdrops, const SpaceOptions& options,
                   const std::vector<char>& inlier, std::vector<Image8>& masks) {
  std::vector<Window> windows = Candidates(images, backdrops, inlier, masks);
  if (windows.empty()) return 0;
  const Space filled(views, masks, options, inlier);
  const std::vector<int> before = Thicknesses(filled, windows);
  for (std::size_t k = 0; k < windows.size(); ++k) windows[k].thick = before[k];
  // Thin regions are not opened with loose matches.
  std::erase_if(windows, [](const Window& window) {
    return window.loose && window.thick <= WindowTuning::kThin;
  });
  for (std::size_t count = 0; count != windows.size();) {
    count = windows.size();
    const Space open(views, Opened(masks, windows), options, inlier);
    const std::vector<int> left = Thicknesses(open, windows);
    std::vector<Window> kept;
    for (std::size_t k = 0; k < count; ++k)
      if (windows[k].Through(left[k])) kept.push_back(windows[k]);
    // Testing which windows meet is expensive, so it is done for the few remaining ones; the final
    // result is the same.
    if (kept.size() == count) {
      const WindowGroups meetings(windows, filled, open);
      kept.clear();
      for (std::size_t k = 0; k < count; ++k)
        if (windows[k].thick <= WindowTuning::kThin || meetings.FromBothSides(k))
          kept.push_back(windows[k]);
    }
    windows = std::move(kept);
  }
  const auto figure = [&] {
    return std::accumulate(masks.begin(), masks.end(), 0.0, [](double sum, const Image8& mask) {
      return sum + static_cast<double>(std::count(mask.data.begin(), mask.data.end(), 255));
    });
  };
  const double was = figure();
  masks = Opened(std::move(masks), windows);
  return (was - figure()) / std::max(was, 1.0);
}

}  // namespace keypose::capture
