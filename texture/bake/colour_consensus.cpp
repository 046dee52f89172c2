#include "texture/bake/colour_consensus.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <queue>

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

/// Connected squares that contain enough of the view's points, grown by one square on all sides.
Image8 Believed(const Blocks& blocks, const std::vector<char>& contrary,
                const std::vector<int>& places, double least, double* held) {
  std::vector<char> seen(contrary.size(), 0);
  Image8 hidden(blocks.width, blocks.height, 1, 0);
  *held = 0;
  for (std::size_t start = 0; start < contrary.size(); ++start) {
    if (!contrary[start] || seen[start]) continue;
    std::vector<int> part{static_cast<int>(start)};
    seen[start] = 1;
    double count = 0;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const int x = part[k] % blocks.width, y = part[k] / blocks.width;
      count += places[part[k]];
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= blocks.width || y + dy >= blocks.height)
            continue;
          const int next = (y + dy) * blocks.width + x + dx;
          if (!contrary[next] || seen[next]) continue;
          seen[next] = 1;
          part.push_back(next);
        }
    }
    if (count < least) continue;
    *held += count;
    for (const int b : part)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = b % blocks.width + dx, y = b / blocks.width + dy;
          if (x >= 0 && y >= 0 && x < blocks.width && y < blocks.height) *hidden.at(x, y) = 255;
        }
  }
  return *held > 0 ? hidden : Image8();
}

void FindHidden(const BakeView& view, const std::vector<const Show*>& of_view,
                const std::vector<char>& contrary, ViewColors* out) {
  using Tuning = ConsensusTuning;
  const Camera& camera = view.view().camera;
  const double side = Tuning::kBlock * std::max(camera.width, camera.height);
  const Blocks blocks{side, static_cast<int>(camera.width / side) + 1,
                      static_cast<int>(camera.height / side) + 1};
  std::vector<int> all(static_cast<std::size_t>(blocks.width) * blocks.height, 0), against(all);
  for (std::size_t i = 0; i < of_view.size(); ++i) {
    const int b = blocks.At(of_view[i]->pixel);
    ++all[b];
    against[b] += contrary[i];
  }
  std::vector<char> bad(all.size(), 0);
  for (std::size_t b = 0; b < all.size(); ++b)
    bad[b] = all[b] >= kLeastInBlock && against[b] >= Tuning::kContraryBlock * all[b];
  double held = 0;
  out->hidden =
      Believed(blocks, bad, all, Tuning::kLeastHidden * static_cast<double>(of_view.size()), &held);
  out->block_px = side;
  out->hidden_share = held / static_cast<double>(of_view.size());
  out->told = !out->hidden.empty() && out->hidden_share >= Tuning::kToldHidden;
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
    if (!colors[v].distrusted) FindHidden(views[v], of_view[v], contrary[v], &colors[v]);
  }
  return colors;
}

}  // namespace keypose::texture
