#include "composite/locating/appearance/grey_term.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/image_quality.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr int kTextureLevels = 6, kLeastSide = 8;
constexpr int kWindow = 7;            // px on each side
constexpr double kFlat = 5;           // grey levels: a window with less contrast is not stretched
constexpr double kLeastFilled = 0.4;  // share of a window inside of the figure
constexpr double kLeastGradient = 0.02;

ImageF Halved(const ImageF& image) {
  ImageF half(image.width / 2, image.height / 2, 1);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      *half.at(x, y) = (*image.at(2 * x, 2 * y) + *image.at(2 * x + 1, 2 * y) +
                        *image.at(2 * x, 2 * y + 1) + *image.at(2 * x + 1, 2 * y + 1)) /
                       4;
  return half;
}

float Bilinear(const ImageF& image, double x, double y) {
  x = std::clamp(x, 0.0, image.width - 1.0);
  y = std::clamp(y, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), image.width - 2);
  const int y0 = std::min(static_cast<int>(y), image.height - 2);
  const float u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
  const float *top = image.at(x0, y0), *low = image.at(x0, y0 + 1);
  return (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * low[0] + u * low[1]);
}

/// The figure as drawn in a box of the picture, and the picture there.
struct Drawn {
  PixelBox box;
  int width = 0, height = 0;
  std::vector<int> face;          // -1: beside the figure
  std::vector<float> u, v, grey;  // on the face; of the texture
  std::vector<char> inside;       // surely inside of the figure, in both pictures

  int at(int x, int y) const { return y * width + x; }
};

Drawn Draw(const Figure& figure, const GreyTexture& texture, const Placement& at) {
  View view;
  view.camera = at.camera;
  view.camera_from_world = at.camera_from_mesh;
  Drawn drawn;
  drawn.box = ProjectedBounds(figure.points, view);
  drawn.width = std::max(0, drawn.box.x1 - drawn.box.x0);
  drawn.height = std::max(0, drawn.box.y1 - drawn.box.y0);
  const std::size_t count = static_cast<std::size_t>(drawn.width) * drawn.height;
  drawn.face.assign(count, -1);
  drawn.u.assign(count, 0);
  drawn.v.assign(count, 0);
  drawn.grey.assign(count, 0);
  const Eigen::Vector3d eye = view.Center();
  const Eigen::Matrix3d turn = at.camera_from_mesh.rotation.conjugate().toRotationMatrix();
  const double depth = (at.camera_from_mesh * figure.center).z();
  const int level = texture.LevelFor(SurfaceArea(figure.points, figure.faces),
                                     depth / std::max(at.camera.fx, 1e-9));
  ParallelFor(
      drawn.height,
      [&](std::int64_t y) {
        for (int x = 0; x < drawn.width; ++x) {
          const Eigen::Vector2d pixel(drawn.box.x0 + x + 0.5,
                                      drawn.box.y0 + static_cast<double>(y) + 0.5);
          const RayScene::Hit hit = figure.scene.Cast(eye, turn * at.camera.Unproject(pixel));
          if (hit.face < 0) continue;
          const int i = drawn.at(x, static_cast<int>(y));
          drawn.face[i] = hit.face;
          drawn.u[i] = static_cast<float>(hit.u);
          drawn.v[i] = static_cast<float>(hit.v);
          drawn.grey[i] = texture.At(hit.face, hit.u, hit.v, level);
        }
      },
      8);
  return drawn;
}

/// Marks the pixels whose neighbours up to two pixels away are all of the figure.
void FindInside(Drawn& drawn, const Image8& matte) {
  constexpr int kBorder = 2;
  const auto in = [&](int x, int y) {
    if (drawn.face[drawn.at(x, y)] < 0) return false;
    return matte.empty() || matte.at(drawn.box.x0 + x, drawn.box.y0 + y)[0] > 127;
  };
  std::vector<char> rows(drawn.face.size(), 0);
  drawn.inside.assign(drawn.face.size(), 0);
  for (int y = 0; y < drawn.height; ++y)
    for (int x = kBorder; x + kBorder < drawn.width; ++x) {
      bool all = true;
      for (int k = -kBorder; k <= kBorder && all; ++k) all = in(x + k, y);
      rows[drawn.at(x, y)] = all;
    }
  for (int y = kBorder; y + kBorder < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x) {
      bool all = true;
      for (int k = -kBorder; k <= kBorder && all; ++k) all = rows[drawn.at(x, y + k)];
      drawn.inside[drawn.at(x, y)] = all;
    }
}

/// Sums over windows by a table of sums from the upper left corner.
class WindowSums {
 public:
  template <class Value>
  WindowSums(int width, int height, const Value& value)
      : width_(width + 1), sums_(static_cast<std::size_t>(width + 1) * (height + 1), 0.0) {
    for (int y = 0; y < height; ++y) {
      double row = 0;
      for (int x = 0; x < width; ++x) {
        row += value(x, y);
        sums_[(y + 1) * width_ + x + 1] = sums_[y * width_ + x + 1] + row;
      }
    }
  }
  double Of(int x0, int y0, int x1, int y1) const {
    return sums_[y1 * width_ + x1] - sums_[y0 * width_ + x1] - sums_[y1 * width_ + x0] +
           sums_[y0 * width_ + x0];
  }

 private:
  int width_;
  std::vector<double> sums_;
};

/// Grey values minus their window's mean over its deviation; 0 outside.
std::vector<float> Normalised(const Drawn& drawn, const std::vector<float>& grey,
                              std::vector<char>& valid) {
  const auto inside = [&](int x, int y) { return drawn.inside[drawn.at(x, y)] ? 1.0 : 0.0; };
  const auto value = [&](int x, int y) {
    return inside(x, y) * static_cast<double>(grey[drawn.at(x, y)]);
  };
  const WindowSums count(drawn.width, drawn.height, inside), sum(drawn.width, drawn.height, value),
      squares(drawn.width, drawn.height, [&](int x, int y) { return value(x, y) * value(x, y); });
  const double full = (2 * kWindow + 1) * (2 * kWindow + 1);
  std::vector<float> normalised(grey.size(), 0);
  valid.assign(grey.size(), 0);
  for (int y = 0; y < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x) {
      const int i = drawn.at(x, y);
      if (!drawn.inside[i]) continue;
      const int x0 = std::max(0, x - kWindow), x1 = std::min(drawn.width, x + kWindow + 1);
      const int y0 = std::max(0, y - kWindow), y1 = std::min(drawn.height, y + kWindow + 1);
      const double n = count.Of(x0, y0, x1, y1);
      if (n < kLeastFilled * full) continue;
      const double mean = sum.Of(x0, y0, x1, y1) / n;
      const double variance = std::max(0.0, squares.Of(x0, y0, x1, y1) / n - mean * mean);
      normalised[i] = static_cast<float>((static_cast<double>(grey[i]) - mean) /
                                         std::max(kFlat, std::sqrt(variance)));
      valid[i] = 1;
    }
  return normalised;
}

Eigen::Vector3d PlaceOn(const Figure& figure, const Drawn& drawn, int i) {
  const auto face = figure.faces.row(drawn.face[i]);
  const double u = static_cast<double>(drawn.u[i]), v = static_cast<double>(drawn.v[i]);
  return (1 - u - v) * figure.points.row(face[0]) + u * figure.points.row(face[1]) +
         v * figure.points.row(face[2]);
}

/// Differences and gradients of two normalised pictures, and their correlation.
GreyMatches Compared(const Figure& figure, const Drawn& drawn, const std::vector<float>& a,
                     const std::vector<float>& b, const std::vector<char>& valid) {
  GreyMatches result;
  std::vector<double> sizes;
  double ab = 0, aa = 0, bb = 0;
  for (int y = 1; y + 1 < drawn.height; ++y)
    for (int x = 1; x + 1 < drawn.width; ++x) {
      const int i = drawn.at(x, y), up = i - drawn.width, down = i + drawn.width;
      if (!valid[i] || !valid[i - 1] || !valid[i + 1] || !valid[up] || !valid[down]) continue;
      const double drawn_here = static_cast<double>(a[i]), filmed_here = static_cast<double>(b[i]);
      ab += drawn_here * filmed_here;
      aa += drawn_here * drawn_here;
      bb += filmed_here * filmed_here;
      // The mean of both gradients: steps then converge quadratically (Benhimane & Malis 2004).
      const Eigen::Vector2d gradient(
          static_cast<double>(a[i + 1] - a[i - 1] + b[i + 1] - b[i - 1]) / 4,
          static_cast<double>(a[down] - a[up] + b[down] - b[up]) / 4);
      if (gradient.squaredNorm() < kLeastGradient * kLeastGradient) continue;
      const double difference = drawn_here - filmed_here;
      sizes.push_back(std::abs(difference));
      result.matches.push_back({PlaceOn(figure, drawn, i), gradient, difference});
    }
  result.correlation = aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
  result.deviation = 1.4826 * UpperMedian(std::move(sizes));
  return result;
}

}  // namespace

ImageF LumaOf(const Image8& picture) {
  ImageF luma(picture.width, picture.height, 1);
  for (std::size_t i = 0; i < luma.data.size(); ++i) {
    const std::uint8_t* p = picture.data.data() + i * picture.channels;
    luma.data[i] = static_cast<float>(picture.channels < 3 ? p[0] : Luma(p));
  }
  return luma;
}

GreyTexture::GreyTexture(const Mesh& mesh, const Image8& texture) : mesh_(mesh) {
  if (!mesh.has_uvs())
    throw InputError(
        "locate: the mesh has no texture coordinates; pass meshes made from the one "
        "that unwrap wrote, or leave out --textures");
  levels_.push_back(LumaOf(texture));
  while (SizeOf(levels_) < kTextureLevels &&
         std::min(levels_.back().width, levels_.back().height) >= 2 * kLeastSide)
    levels_.push_back(Halved(levels_.back()));
  for (Eigen::Index f = 0; f < mesh.uv_faces.rows(); ++f) {
    const Eigen::Vector2d a = mesh.uvs.row(mesh.uv_faces(f, 0)),
                          b = mesh.uvs.row(mesh.uv_faces(f, 1)),
                          c = mesh.uvs.row(mesh.uv_faces(f, 2));
    uv_area_ += std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x()) / 2;
  }
}

int GreyTexture::LevelFor(double area, double footprint) const {
  const double texels = levels_[0].width * std::sqrt(uv_area_ / std::max(area, 1e-300));
  const double a_pixel = std::max(texels * footprint, 1e-9);
  return std::clamp(static_cast<int>(std::floor(std::log2(a_pixel) + 0.5)), 0, SizeOf(levels_) - 1);
}

float GreyTexture::At(int face, double u, double v, int level) const {
  const Eigen::Vector2d uv = (1 - u - v) * mesh_.uvs.row(mesh_.uv_faces(face, 0)) +
                             u * mesh_.uvs.row(mesh_.uv_faces(face, 1)) +
                             v * mesh_.uvs.row(mesh_.uv_faces(face, 2));
  const ImageF& image = levels_[level];
  return Bilinear(image, uv.x() * image.width - 0.5, (1 - uv.y()) * image.height - 0.5);
}

GreyMatches MatchGreys(const Figure& figure, const GreyTexture& texture, const ImageF& luma,
                       const Image8& matte, const Placement& at) {
  Drawn drawn = Draw(figure, texture, at);
  FindInside(drawn, matte);
  std::vector<float> filmed(drawn.grey.size(), 0);
  for (int y = 0; y < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x)
      filmed[drawn.at(x, y)] = *luma.at(drawn.box.x0 + x, drawn.box.y0 + y);
  std::vector<char> valid;
  const std::vector<float> a = Normalised(drawn, drawn.grey, valid),
                           b = Normalised(drawn, filmed, valid);
  return Compared(figure, drawn, a, b, valid);
}

}  // namespace keypose::composite
