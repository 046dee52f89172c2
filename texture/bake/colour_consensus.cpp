#include "texture/bake/colour_consensus.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kConsensusSamples = 20000;  // evenly distributed points on the surface
constexpr int kLeastViews = 4;            // fewer have no majority
constexpr double kLeastCosine = 0.35;
constexpr float kLevel = 2;  // colours are means over 4 pixels in each direction
constexpr int kLeastInBlock = 4;
constexpr int kLeastForLight = 100;

/// One view's colour at one point, and its difference from most views'.
struct Show {
  int view;
  Vector2d pixel,
      normal;    // pixel in the photograph; the surface's normal, right and down in the camera's
                 // frame
  Vector3d hue;  // unit
  double brightness;  // logarithm
  double hue_off = 0, brightness_off = 0;
  Vector3d usual_hue = Vector3d::Zero();  // of all views at the point
  double usual_brightness = 0;
};
using Shows = std::vector<std::vector<Show>>;  // one list per point

void CompareToMedian(std::vector<Show>& list) {
  std::vector<double> values(list.size());
  const auto median = [&](auto value) {
    for (std::size_t i = 0; i < list.size(); ++i) values[i] = value(list[i]);
    return UpperMedianInPlace(values);
  };
  Vector3d hue;
  for (int c = 0; c < 3; ++c) hue[c] = median([c](const Show& s) { return s.hue[c]; });
  hue.normalize();
  const double brightness = median([](const Show& s) { return s.brightness; });
  for (Show& s : list) {
    s.hue_off = std::acos(std::clamp(s.hue.dot(hue), -1.0, 1.0));
    s.brightness_off = s.brightness - brightness;
    s.usual_hue = hue;
    s.usual_brightness = brightness;
  }
}

Shows Look(const Mesh& mesh, const std::vector<BakeView>& views,
           const std::vector<Eigen::Vector3f>& gains, const std::vector<char>& used) {
  const SurfaceSamples surface = SampleSurface(mesh.points, mesh.faces, kConsensusSamples, 21);
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
  Shows shows(static_cast<std::size_t>(kConsensusSamples));
  ParallelFor(
      kConsensusSamples,
      [&](std::int64_t i) {
        std::vector<Show>& list = shows[i];
        const Vector3d x = surface.points.row(i), n = normals.row(surface.faces[i]);
        for (int v = 0; v < std::ssize(views); ++v) {
          if (!used[v] || n.dot((views[v].center() - x).normalized()) < kLeastCosine) continue;
          const Sighting sighting = views[v].See(x);
          if (sighting.trust <= 0) continue;
          const Sample sample = views[v].ColorAt(sighting.pixel.cast<float>(), kLevel);
          // Clipped colours have no hue.
          if (sample.alpha <= 0 || sample.color.maxCoeff() > 0.95f ||
              sample.color.maxCoeff() < 0.003f)
            continue;
          const Vector3d root = sample.color.cwiseProduct(gains[v]).cwiseSqrt().cast<double>();
          const Vector3d before = views[v].view().camera_from_world.rotation * n;
          list.push_back(
              {v, sighting.pixel, before.head<2>(), root.normalized(), std::log(root.norm())});
        }
        if (SizeOf(list) < kLeastViews)
          list.clear();
        else
          CompareToMedian(list);
      },
      64);
  return shows;
}

/// Robust gradient of brightness with respect to the normal: a hand or a shadow is an outlier.
Vector2d LightOf(const std::vector<const Show*>& of_view, double* constant) {
  constexpr double kUsual = 0.1;
  Vector3d fit = Vector3d::Zero();
  for (int round = 0; round < 6; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Identity() * 1e-6;
    Vector3d b = Vector3d::Zero();
    for (const Show* s : of_view) {
      const Vector3d row(1, s->normal.x(), s->normal.y());
      const double miss = s->brightness_off - fit.dot(row),
                   weight = round == 0 ? 1 : 1 / (1 + miss * miss / (kUsual * kUsual));
      a += weight * row * row.transpose();
      b += weight * s->brightness_off * row;
    }
    fit = a.ldlt().solve(b);
  }
  *constant = fit[0];
  return fit.tail<2>();
}

/// Squares of a picture.
struct Blocks {
  double side;
  int width, height;
  int At(const Vector2d& pixel) const {
    const int x = std::clamp(static_cast<int>(pixel.x() / side), 0, width - 1);
    return std::clamp(static_cast<int>(pixel.y() / side), 0, height - 1) * width + x;
  }
};

/// What the squares of a picture hold.
struct BlockCounts {
  std::vector<int> places, contrary;
  std::vector<int> foreign;  // contrary, and no place nearby has the colour either
  std::vector<char> beside;  // the figure fills less than half of it
};

bool IsContrary(const BlockCounts& counts, const std::vector<int>& against, std::size_t b) {
  return counts.places[b] >= kLeastInBlock &&
         against[b] >= ConsensusTuning::kContraryBlock * counts.places[b];
}

/// Calls body(square) for a square and those around it.
template <class Body>
void ForAround(const Blocks& blocks, int b, const Body& body) {
  const int x = b % blocks.width, y = b / blocks.width;
  for (int v = std::max(0, y - 1); v <= std::min(blocks.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(blocks.width - 1, x + 1); ++u)
      body(v * blocks.width + u);
}

/// Connected squares that are contrary.
std::vector<std::vector<int>> PartsOf(const Blocks& blocks, const BlockCounts& counts) {
  std::vector<char> seen(counts.places.size(), 0);
  std::vector<std::vector<int>> parts;
  for (std::size_t start = 0; start < seen.size(); ++start) {
    if (seen[start] || !IsContrary(counts, counts.contrary, start)) continue;
    std::vector<int> part{static_cast<int>(start)};
    seen[start] = 1;
    for (std::size_t k = 0; k < part.size(); ++k)
      ForAround(blocks, part[k], [&](int next) {
        const auto at = static_cast<std::size_t>(next);
        if (seen[at] || !IsContrary(counts, counts.contrary, at)) return;
        seen[at] = 1;
        part.push_back(next);
      });
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Whether a part is a thing before the figure. Nothing floats there: it reaches in from beside the
/// figure. And its colours are its own, where a surface that lies a little elsewhere than thought
/// shows colours that the figure has nearby.
bool ReachesIn(const Blocks& blocks, const BlockCounts& counts, const std::vector<int>& part,
               double least) {
  double own = 0;
  bool from_beside = false;
  for (const int b : part) {
    const auto at = static_cast<std::size_t>(b);
    if (IsContrary(counts, counts.foreign, at)) own += counts.places[at];
    ForAround(blocks, b,
              [&](int next) { from_beside |= counts.beside[static_cast<std::size_t>(next)] != 0; });
  }
  return from_beside && own >= least;
}

/// Marks the samples of a view whose colour the figure should have within this many pixels.
std::vector<char> KnownNearby(const std::vector<const Show*>& of_view,
                              const std::vector<char>& contrary, const Blocks& blocks,
                              const ViewColors& light, double constant) {
  using Tuning = ConsensusTuning;
  const double reach = blocks.side / 2;
  std::vector<std::vector<const Show*>> in(static_cast<std::size_t>(blocks.width) * blocks.height);
  for (const Show* s : of_view) in[static_cast<std::size_t>(blocks.At(s->pixel))].push_back(s);
  std::vector<char> known(of_view.size(), 0);
  for (std::size_t i = 0; i < of_view.size(); ++i) {
    if (!contrary[i]) continue;
    const Show& s = *of_view[i];
    ForAround(blocks, blocks.At(s.pixel), [&](int b) {
      if (known[i]) return;
      for (const Show* other : in[static_cast<std::size_t>(b)]) {
        if ((other->pixel - s.pixel).squaredNorm() > reach * reach) continue;
        const double hue = std::acos(std::clamp(s.hue.dot(other->usual_hue), -1.0, 1.0)),
                     lit = s.brightness - other->usual_brightness - constant -
                           light.light.dot(other->normal);
        if (std::hypot(hue / Tuning::kHue, lit / Tuning::kBrightness) > 1) continue;
        known[i] = 1;
        return;
      }
    });
  }
  return known;
}

/// Squares of which the figure fills less than half.
std::vector<char> Beside(const BakeView& view, const Blocks& blocks) {
  std::vector<int> rays(static_cast<std::size_t>(blocks.width) * blocks.height, 0), good(rays);
  for (int y = 0; y < view.rays_high(); ++y)
    for (int x = 0; x < view.rays_wide(); ++x) {
      const auto b = static_cast<std::size_t>(blocks.At(view.RayPixel(x, y)));
      ++rays[b];
      good[b] += view.RayIsGood(x, y);
    }
  std::vector<char> beside(rays.size());
  for (std::size_t b = 0; b < rays.size(); ++b) beside[b] = 2 * good[b] < std::max(1, rays[b]);
  return beside;
}

void FindHidden(const BakeView& view, const std::vector<const Show*>& of_view,
                const std::vector<char>& contrary, double constant, ViewColors* out) {
  using Tuning = ConsensusTuning;
  const Camera& camera = view.view().camera;
  const double side = Tuning::kBlock * std::max(camera.width, camera.height);
  const Blocks blocks{side, static_cast<int>(camera.width / side) + 1,
                      static_cast<int>(camera.height / side) + 1};
  BlockCounts counts{
      std::vector<int>(static_cast<std::size_t>(blocks.width) * blocks.height, 0), {}, {}, {}};
  counts.foreign = counts.contrary = counts.places;
  const std::vector<char> known = KnownNearby(of_view, contrary, blocks, *out, constant);
  for (std::size_t i = 0; i < of_view.size(); ++i) {
    const auto b = static_cast<std::size_t>(blocks.At(of_view[i]->pixel));
    ++counts.places[b];
    counts.contrary[b] += contrary[i];
    counts.foreign[b] += contrary[i] && !known[i];
  }
  counts.beside = Beside(view, blocks);
  const auto all = static_cast<double>(of_view.size());
  Image8 hidden(blocks.width, blocks.height, 1, 0);
  double held = 0, told = 0;
  for (const std::vector<int>& part : PartsOf(blocks, counts)) {
    double count = 0;
    for (const int b : part) count += counts.places[static_cast<std::size_t>(b)];
    if (count < Tuning::kLeastHidden * all) continue;
    held += count;
    if (ReachesIn(blocks, counts, part, Tuning::kLeastHidden * all)) told += count;
    for (const int b : part)
      ForAround(blocks, b, [&](int near) { hidden.data[static_cast<std::size_t>(near)] = 255; });
  }
  if (held > 0) out->hidden = std::move(hidden);
  out->block_px = side;
  out->hidden_share = held / all;
  out->told = told >= Tuning::kToldHidden * all;
  out->told_share = told / all;
}

/// The centre of the closest half of the values: the majority's value, if a minority lies on one
/// side.
double MiddleOfHalf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2 + 1;
  std::size_t best = 0;
  for (std::size_t i = 0; i + half <= values.size(); ++i)
    if (values[i + half - 1] - values[i] < values[best + half - 1] - values[best]) best = i;
  return values[best + half / 2];
}

/// Marks the views whose lamp is elsewhere than in most views.
void FindOtherLights(std::vector<ViewColors>& colors) {
  std::vector<double> x, y, away;
  for (const ViewColors& c : colors)
    if (c.places >= kLeastForLight) {
      x.push_back(c.light.x());
      y.push_back(c.light.y());
    }
  if (x.size() < kLeastViews) return;
  const Vector2d usual(MiddleOfHalf(x), MiddleOfHalf(y));
  for (const ViewColors& c : colors)
    if (c.places >= kLeastForLight) away.push_back((c.light - usual).norm());
  const double limit =
      std::max(ConsensusTuning::kLight, ConsensusTuning::kSpread * UpperMedian(std::move(away)));
  for (ViewColors& c : colors)
    c.other_light = c.places >= kLeastForLight && (c.light - usual).norm() > limit;
}

}  // namespace

std::vector<ViewColors> JudgeColors(const Mesh& mesh, const std::vector<BakeView>& views,
                                    const std::vector<Eigen::Vector3f>& gains,
                                    const std::vector<char>& used) {
  using Tuning = ConsensusTuning;
  Shows shows = Look(mesh, views, gains, used);
  std::vector<std::vector<const Show*>> of_view(views.size());
  for (const std::vector<Show>& list : shows)
    for (const Show& s : list) of_view[s.view].push_back(&s);
  std::vector<ViewColors> colors(views.size());
  std::vector<double> constants(views.size(), 0);
  for (std::size_t v = 0; v < views.size(); ++v) {
    colors[v].places = SizeOf(of_view[v]);
    if (colors[v].places >= kLeastForLight) colors[v].light = LightOf(of_view[v], &constants[v]);
  }
  FindOtherLights(colors);
  // Differences between the views at a point, after correction for each one's lamp.
  std::vector<std::vector<char>> contrary(views.size());
  for (const std::vector<Show>& list : shows) {
    if (list.empty()) continue;
    std::vector<double> off;
    for (const Show& s : list) {
      const auto v = static_cast<std::size_t>(s.view);
      const double lit = s.brightness_off - constants[v] - colors[v].light.dot(s.normal);
      off.push_back(std::hypot(s.hue_off / Tuning::kHue, lit / Tuning::kBrightness));
    }
    std::vector<double> sorted = off;
    const double limit = std::max(1.0, Tuning::kSpread * UpperMedianInPlace(sorted));
    for (std::size_t i = 0; i < list.size(); ++i) contrary[list[i].view].push_back(off[i] > limit);
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (colors[v].places < kLeastForLight) continue;
    const auto against = std::count(contrary[v].begin(), contrary[v].end(), 1);
    colors[v].contrary = static_cast<double>(against) / colors[v].places;
    colors[v].distrusted = colors[v].contrary > Tuning::kMostContrary;
    if (!colors[v].distrusted)
      FindHidden(views[v], of_view[v], contrary[v], constants[v], &colors[v]);
  }
  return colors;
}

}  // namespace keypose::texture
