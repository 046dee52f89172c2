#include "capture/windows.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <numeric>

#include "capture/space_grid.h"
#include "core/parallel.h"

namespace keypose::capture {
namespace {

constexpr int kThin = 9;         // per cent of the hull's longest side, that the others may leave of a window's rays
constexpr double kLeft = 0.45;  // of what the hull was before, that they may leave of a window which is only loosely like the empty set

constexpr double kOpposite = -0.6;   // largest product of the directions of views that look at each other
constexpr double kFromBehind = 0.2;  // of a window's pixels, that such a view sees through as well

struct Window {
  std::size_t view = 0;
  Region pixels;
  bool loose = false;  ///< only loosely like the empty set
  int thick = 0;       ///< per cent of the hull's longest side, with the masks as they were

  bool Through(int left) const { return left <= (loose ? std::min<double>(kThin, kLeft * thick) : kThin); }
};

std::vector<Window> Candidates(const std::vector<Image8>& images, const std::vector<Backdrop>& backdrops, const std::vector<char>& say,
                               const std::vector<Image8>& masks) {
  std::vector<std::vector<Window>> found(images.size());
  ParallelFor(static_cast<std::int64_t>(images.size()), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    if (!say.empty() && !say[i]) return;
    for (const bool loose : {false, true})
      for (Region& region : FindGaps(images[i], backdrops[i], masks[i], loose)) found[i].push_back({i, std::move(region), loose});
  });
  std::vector<Window> windows;
  for (std::vector<Window>& of : found) std::move(of.begin(), of.end(), std::back_inserter(windows));
  return windows;
}

/// The rim mixes window and figure, so it opens as well.
void Open(const Window& window, Image8& mask) {
  for (const std::int32_t at : window.pixels) {
    const int x = at % mask.width, y = at / mask.width;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      if (x + dx >= 0 && y + dy >= 0 && x + dx < mask.width && y + dy < mask.height) *mask.at(x + dx, y + dy) = 0;
  }
}

struct Space {
  std::vector<Witness> witnesses;
  Grid grid;

  Space(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& options, const std::vector<char>& say)
      : witnesses(WitnessesOf(views, masks, options.margin_px, say)), grid(SharedSpace(views, masks, witnesses, options)) {}
};

Eigen::Vector3d RayOf(const View& view, double x, double y) {
  return (view.camera_from_world.rotation.conjugate() * view.camera.Unproject({x, y})).normalized();
}

/// Median over each window's pixels of what the other views leave of their rays, per cent of the hull's longest side.
std::vector<int> Thicknesses(const Space& space, const std::vector<Window>& windows) {
  const int longest = LongestSide(space.grid);
  std::vector<int> thicknesses(windows.size());
  ParallelFor(static_cast<std::int64_t>(windows.size()), [&](std::int64_t k) {
    const Window& window = windows[static_cast<std::size_t>(k)];
    const Witness& witness = space.witnesses[window.view];
    std::vector<int> chords;
    for (const std::int32_t at : window.pixels)
      chords.push_back(ChordOf(witness, at % witness.denied.width, at / witness.denied.width, space.grid, true));
    std::nth_element(chords.begin(), chords.begin() + static_cast<std::ptrdiff_t>(chords.size() / 2), chords.end());
    thicknesses[static_cast<std::size_t>(k)] = 100 * chords[chords.size() / 2] / longest;
  });
  return thicknesses;
}

/// Share of a window's pixels whose rays meet, where the hull was, an opening of a view that looks the other way. What is painted on one side of the figure is
/// seen from that side alone, however thin the figure is.
double SeenFromBehind(const Window& window, const Space& filled, const Space& open) {
  const Grid& grid = filled.grid;
  const Witness& own = open.witnesses[window.view];
  int met = 0;
  for (const std::int32_t at : window.pixels) {
    const Eigen::Vector3d ray = RayOf(*own.view, at % own.denied.width + 0.5, at / own.denied.width + 0.5);
    const Eigen::Vector3d from = own.view->Center();
    const double nearest = ray.dot(grid.Center(0, 0, 0) + 0.5 * grid.cell * grid.size.cast<double>() - from);
    const double reach = 0.5 * grid.cell * grid.size.cast<double>().norm();
    bool behind = false;
    for (double t = nearest - reach; t < nearest + reach && !behind; t += grid.cell) {
      const Eigen::Vector3i cell = ((from + t * ray - grid.low) / grid.cell).array().floor().cast<int>();
      if ((cell.array() < 0).any() || (cell.array() >= grid.size.array()).any() || grid.denials[grid.At(cell.x(), cell.y(), cell.z())] > 0)
        continue;
      const Eigen::Vector3d x = grid.Center(cell.x(), cell.y(), cell.z());
      for (const Witness& witness : open.witnesses) {
        Eigen::Vector3d pixel;
        behind = behind || (witness.heard && ray.dot((x - witness.view->Center()).normalized()) < kOpposite &&
                            witness.Of(x, &pixel) == Witness::kDenied);
      }
    }
    met += behind;
  }
  return static_cast<double>(met) / static_cast<double>(window.pixels.size());
}

std::vector<Image8> Opened(std::vector<Image8> masks, const std::vector<Window>& windows) {
  for (const Window& window : windows) Open(window, masks[window.view]);
  return masks;
}

}  // namespace

double OpenWindows(const std::vector<Image8>& images, const std::vector<View>& views, const std::vector<Backdrop>& backdrops,
                const SpaceOptions& options, const std::vector<char>& say, std::vector<Image8>& masks) {
  std::vector<Window> windows = Candidates(images, backdrops, say, masks);
  if (windows.empty()) return 0;
  const Space filled(views, masks, options, say);
  const std::vector<int> before = Thicknesses(filled, windows);
  for (std::size_t k = 0; k < windows.size(); ++k) windows[k].thick = before[k];
  // What is thin already needs no window to be seen past, so there only what is closely like the empty set counts.
  std::erase_if(windows, [](const Window& window) { return window.loose && window.thick <= kThin; });
  for (std::size_t count = 0; count != windows.size();) {
    count = windows.size();
    const Space open(views, Opened(masks, windows), options, say);
    const std::vector<int> left = Thicknesses(open, windows);
    std::vector<char> through(count);
    ParallelFor(static_cast<std::int64_t>(count), [&](std::int64_t i) {
      const auto k = static_cast<std::size_t>(i);
      const Window& window = windows[k];
      through[k] = window.Through(left[k]) && (window.thick <= kThin || SeenFromBehind(window, filled, open) >= kFromBehind);
    });
    std::vector<Window> kept;
    for (std::size_t k = 0; k < count; ++k)
      if (through[k]) kept.push_back(std::move(windows[k]));
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
