#include "report/evidence/view_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/numbers/statistics.h"
#include "core/pictures/image_quality.h"
#include "core/pictures/render.h"
#include "core/pictures/scan_conversion.h"
#include "core/pictures/undistorted.h"
#include "report/evidence/verdict_limits.h"

namespace keypose::report {
namespace {

using Plane = std::vector<float>;

constexpr std::size_t kPairsShown = 3;

bool InMask(const Image8& mask, int x, int y) {
  return x >= 0 && y >= 0 && x < mask.width && y < mask.height && *mask.at(x, y) >= 128;
}

/// Separable Gaussian of planes, normalised by one weight. Pixels of weight 0 have no effect, and
/// get 0.
class Smoother {
 public:
  Smoother(const Plane& weight, int width, int height, double sigma)
      : weight_(weight), width_(width), height_(height), mass_(Columns(Rows(weight, sigma))) {}

  Plane Smoothed(const Plane& values) const {
    Plane weighted(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) weighted[i] = weight_[i] * values[i];
    Plane smooth = Columns(Rows(weighted));
    for (std::size_t i = 0; i < values.size(); ++i)
      smooth[i] = weight_[i] > 0 ? smooth[i] / mass_[i] : 0;
    return smooth;
  }

 private:
  Plane Rows(const Plane& values, double sigma) {
    radius_ = static_cast<int>(std::ceil(3 * sigma));
    for (int i = -radius_; i <= radius_; ++i)
      kernel_.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma))));
    return Rows(values);
  }
  float* Row(Plane& plane, int y) const {
    return plane.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  }
  const float* Row(const Plane& plane, int y) const {
    return plane.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  }
  Plane Rows(const Plane& values) const {
    Plane sum(values.size(), 0.0F);
    for (int y = 0; y < height_; ++y)
      for (int i = -radius_; i <= radius_; ++i) {
        const float k = kernel_[i + radius_];
        const float* from = Row(values, y) + i;
        float* to = Row(sum, y);
        for (int x = std::max(0, -i); x < std::min(width_, width_ - i); ++x) to[x] += k * from[x];
      }
    return sum;
  }
  Plane Columns(const Plane& values) const {
    Plane sum(values.size(), 0.0F);
    for (int y = 0; y < height_; ++y)
      for (int i = std::max(-radius_, -y); i <= std::min(radius_, height_ - 1 - y); ++i) {
        const float k = kernel_[i + radius_];
        const float* from = Row(values, y + i);
        float* to = Row(sum, y);
        for (int x = 0; x < width_; ++x) to[x] += k * from[x];
      }
    return sum;
  }

  const Plane& weight_;
  int width_, height_, radius_ = 0;
  std::vector<float> kernel_;
  Plane mass_;
};

/// Details of one to a few pixels: a band-pass removes noise, light and exposure.
Plane Details(const Image8& rgb, const Smoother& fine, const Smoother& coarse) {
  Plane luma(rgb.data.size() / 3);
  for (std::size_t i = 0; i < luma.size(); ++i)
    luma[i] = static_cast<float>(Luma(&rgb.data[3 * i]));
  const Plane blurred = coarse.Smoothed(luma);
  luma = fine.Smoothed(luma);
  for (std::size_t i = 0; i < luma.size(); ++i) luma[i] -= blurred[i];
  return luma;
}

/// Correlation of the details where mask and mesh overlap, at least two pixels inside their
/// borders.
double Structure(const Image8& photograph, const Image8& render, const Image8& mask,
                 const Image8& covered) {
  Plane weight(mask.data.size(), 0.0F);
  constexpr int kRim = 2;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      bool inside = true;
      for (const auto& [dx, dy] : {std::pair{0, 0}, {-kRim, 0}, {kRim, 0}, {0, -kRim}, {0, kRim}})
        inside = inside && InMask(mask, x + dx, y + dy) && InMask(covered, x + dx, y + dy);
      if (inside)
        weight[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
               static_cast<std::size_t>(x)] = 1;
    }
  const Smoother fine(weight, mask.width, mask.height, 1),
      coarse(weight, mask.width, mask.height, 5);
  const Plane a = Details(photograph, fine, coarse), b = Details(render, fine, coarse);
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    if (weight[i] == 0) continue;
    aa += static_cast<double>(a[i]) * a[i];
    bb += static_cast<double>(b[i]) * b[i];
    ab += static_cast<double>(a[i]) * b[i];
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

struct MaskBox {
  int x0, y0, x1 = -1, y1 = -1;
  double Diagonal() const { return std::hypot(x1 - x0 + 1, y1 - y0 + 1); }
};
MaskBox BoxOf(const Image8& mask) {
  MaskBox box{mask.width, mask.height};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (InMask(mask, x, y))
        box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x), std::max(box.y1, y)};
  return box;
}

bool OnRim(const Image8& mask, int x, int y) {
  return InMask(mask, x, y) && !(InMask(mask, x - 1, y) && InMask(mask, x + 1, y) &&
                                 InMask(mask, x, y - 1) && InMask(mask, x, y + 1));
}

void CompareOutlines(const Image8& mask, const Image8& covered, ViewEvidence& out) {
  long both = 0, either = 0, rim = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const bool m = InMask(mask, x, y), c = InMask(covered, x, y);
      both += m && c;
      either += m || c;
      rim += OnRim(mask, x, y) + OnRim(covered, x, y);
    }
  if (both == 0 || rim == 0) return;
  out.iou = static_cast<double>(both) / static_cast<double>(either);
  // The mean distance of two outlines is the area between them divided by their length.
  const double length = 0.5 * static_cast<double>(rim),
               between = static_cast<double>(either - both);
  out.outline_off = std::min(1.0, between / length / BoxOf(mask).Diagonal());
}

/// The slightly smoothed colour at a point.
std::array<double, 3> ColorAround(const Image8& image, double px, double py) {
  std::array<double, 3> sum{};
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = std::clamp(static_cast<int>(std::lround(px)) + dx, 0, image.width - 1),
                y = std::clamp(static_cast<int>(std::lround(py)) + dy, 0, image.height - 1);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += image.at(x, y)[c] / 9.0;
    }
  return sum;
}

/// Share of the mesh's outline across which the photograph changes colour. Ignores the picture's
/// border.
double EdgesUnderOutline(const Image8& photograph, const Image8& covered) {
  constexpr double kReach = 3.5, kLevels = 10;
  constexpr int kAway = 6;
  long seen = 0, told = 0;
  for (int y = kAway; y < covered.height - kAway; ++y)
    for (int x = kAway; x < covered.width - kAway; ++x) {
      if (!OnRim(covered, x, y)) continue;
      double nx = 0, ny = 0;  // outward
      for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx)
          if (!InMask(covered, x + dx, y + dy)) {
            nx += dx;
            ny += dy;
          }
      const double length = std::hypot(nx, ny);
      if (length < 1e-9) continue;
      nx *= kReach / length;
      ny *= kReach / length;
      const auto in = ColorAround(photograph, x - nx, y - ny),
                 out = ColorAround(photograph, x + nx, y + ny);
      double largest = 0;
      for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(in[c] - out[c]));
      ++seen;
      told += largest > kLevels;
    }
  return seen > 0 ? static_cast<double>(told) / static_cast<double>(seen) : 0;
}

RenderOptions AsTextured(const Mesh& mesh, const Image8* texture) {
  RenderOptions look;
  look.texture = mesh.has_uvs() ? texture : nullptr;
  look.shading = 0;
  look.samples = 2;
  look.background = {255, 255, 255};
  return look;
}

double MiddleOf(const std::vector<ViewEvidence>& views, double ViewEvidence::*member) {
  std::vector<double> values;
  for (const ViewEvidence& view : views) values.push_back(view.*member);
  return UpperMedian(std::move(values));
}

/// The box with the places at which a pinhole camera shows what is on its border, within the
/// picture.
PixelBox WithItsPinhole(PixelBox box, const Camera& camera) {
  if (!camera.distorted()) return box;
  const PixelBox bent = box;
  for (const double x : {0.0, 0.5, 1.0})
    for (const double y : {0.0, 0.5, 1.0}) {
      const Eigen::Vector2d at(bent.x0 + x * (bent.x1 - bent.x0),
                               bent.y0 + y * (bent.y1 - bent.y0));
      const Eigen::Vector2d straight = Pinhole(camera).Project(camera.Unproject(at));
      box.x0 = std::min(box.x0, static_cast<int>(std::floor(straight.x())));
      box.y0 = std::min(box.y0, static_cast<int>(std::floor(straight.y())));
      box.x1 = std::max(box.x1, static_cast<int>(std::ceil(straight.x())));
      box.y1 = std::max(box.y1, static_cast<int>(std::ceil(straight.y())));
    }
  return {std::max(0, box.x0), std::max(0, box.y0), std::min(camera.width, box.x1),
          std::min(camera.height, box.y1)};
}

}  // namespace

Image8 Covered(const Mesh& mesh, const RayScene& scene, const View& view) {
  Image8 covered(view.camera.width, view.camera.height, 1);
  const auto scan = ScanConversion::Of(mesh.points, mesh.faces, view, {{0.5, 0.5}});
  if (!scan) {
    const Raster raster = Rasterize(mesh, scene, view);
    for (std::size_t i = 0; i < covered.data.size(); ++i)
      covered.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
    return covered;
  }
  std::vector<RayScene::Hit> hits;
  scan->Fill({0, 0, covered.width, covered.height}, {}, hits);
  for (std::size_t i = 0; i < covered.data.size(); ++i)
    covered.data[i] = hits[i].face >= 0 ? 255 : 0;
  return covered;
}

double ViewEvidence::Misfit() const {
  return std::max(outline_off / kViewOutlineLook, (1 - structure) / (1 - kViewStructureLook));
}

Shot Cropped(const Shot& shot, const PointsX3& points) {
  constexpr int kMargin = 12;
  const PixelBox mesh = ProjectedBounds(points, shot.view);
  const MaskBox mask = BoxOf(shot.mask);
  PixelBox box = mesh;
  if (mask.x1 >= 0 && mesh.empty()) box = {mask.x0, mask.y0, mask.x1 + 1, mask.y1 + 1};
  if (mask.x1 >= 0 && !mesh.empty())
    box = {std::min(mesh.x0, mask.x0), std::min(mesh.y0, mask.y0), std::max(mesh.x1, mask.x1 + 1),
           std::max(mesh.y1, mask.y1 + 1)};
  box = {std::max(0, box.x0 - kMargin), std::max(0, box.y0 - kMargin),
         std::min(shot.photograph.width, box.x1 + kMargin),
         std::min(shot.photograph.height, box.y1 + kMargin)};
  if (box.empty()) box = {0, 0, shot.photograph.width, shot.photograph.height};
  box = WithItsPinhole(box, shot.view.camera);
  Shot part{shot.view, {}, {}};
  Camera& camera = part.view.camera;
  camera.width = box.x1 - box.x0;
  camera.height = box.y1 - box.y0;
  camera.cx -= box.x0;
  camera.cy -= box.y0;
  part.photograph = Image8(camera.width, camera.height, 3);
  part.mask = Image8(camera.width, camera.height, 1);
  for (int y = 0; y < camera.height; ++y) {
    std::copy_n(shot.photograph.at(box.x0, box.y0 + y), 3 * camera.width, part.photograph.at(0, y));
    std::copy_n(shot.mask.at(box.x0, box.y0 + y), camera.width, part.mask.at(0, y));
  }
  if (!camera.distorted()) return part;
  part.photograph = Undistorted(part.photograph, camera);
  part.mask = Undistorted(part.mask, camera);
  camera = Pinhole(camera);
  return part;
}

ViewEvidence CompareView(const Mesh& mesh, const RayScene& scene, const Image8* texture,
                         const Shot& shot) {
  ViewEvidence evidence;
  evidence.name = shot.view.name;
  const Image8 covered = Covered(mesh, scene, shot.view);
  CompareOutlines(shot.mask, covered, evidence);
  const Image8 render = Render(mesh, scene, shot.view, AsTextured(mesh, texture));
  evidence.structure = Structure(shot.photograph, render, shot.mask, covered);
  evidence.edges = EdgesUnderOutline(shot.photograph, covered);
  return evidence;
}

Image8 SideBySide(const Mesh& mesh, const RayScene& scene, const Image8* texture,
                  const Shot& shot) {
  Image8 pair[2] = {shot.photograph, Render(mesh, scene, shot.view, AsTextured(mesh, texture))};
  const std::uint8_t orange[3] = {255, 120, 0};
  for (Image8& image : pair)
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (OnRim(shot.mask, x, y)) std::copy_n(orange, 3, image.at(x, y));
  return TileImages({pair[0], pair[1]}, 2, 6);
}

PoseEvidence Summarize(std::vector<ViewEvidence> views) {
  PoseEvidence pose;
  pose.views = std::move(views);
  if (pose.views.empty()) return pose;
  pose.outline_off = MiddleOf(pose.views, &ViewEvidence::outline_off);
  pose.structure = MiddleOf(pose.views, &ViewEvidence::structure);
  pose.edges = MiddleOf(pose.views, &ViewEvidence::edges);
  pose.worst.resize(pose.views.size());
  std::iota(pose.worst.begin(), pose.worst.end(), 0);
  std::stable_sort(pose.worst.begin(), pose.worst.end(),
                   [&](int a, int b) { return pose.views[a].Misfit() > pose.views[b].Misfit(); });
  pose.worst.resize(std::min(pose.worst.size(), kPairsShown));
  return pose;
}

}  // namespace keypose::report
