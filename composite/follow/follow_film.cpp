#include "composite/follow/follow_film.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <vector>

#include "composite/layer/linear_light.h"
#include "core/numbers/cholesky.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Chosen on the generated shot of synth's seed 1.
struct FollowTuning {
  KEYPOSE_TUNED(double, kStiffness, 6);  // of the membrane, over a vertex' evidence
  KEYPOSE_TUNED(double, kOutlier, 30);   // stored levels: no place has moved as much
};

constexpr int kAlong = 2;           // rays along a pixel's side
constexpr double kRidge = 1e-4;     // of the membrane: holds parts that nothing shows
constexpr double kReference = 960;  // picture width that the blurs are for

constexpr double kMeasured = 0.7;  // px: blur of the figures before and after

struct Level {
  double sigma_px, stiffness;
  int rounds;
};
constexpr Level kLevels[] = {{4, 4, 2}, {2, 2, 2}, {1, 1, 3}};

/// The face before each pixel, also a few pixels beyond the outline.
struct Faces {
  std::vector<RayScene::Hit> hits;
  std::vector<std::uint8_t> ring;  // 0: on the character; n: so many pixels beside; 255: farther
};

class Follower {
 public:
  Follower(const FollowedFrame& frame, const PointsX3& points)
      : frame_(frame),
        start_(points),
        points_(points),
        edges_(UndirectedEdges(frame.character.faces)),
        shifts_(Eigen::Matrix<double, Eigen::Dynamic, 2>::Zero(points.rows(), 2)),
        seen_(static_cast<std::size_t>(points.rows()), 0),
        width_(frame.filmed.width),
        height_(frame.filmed.height) {}

  Followed Run() {
    const double scale = std::max(width_, height_) / kReference;
    Compare(kMeasured * scale, true);
    bool first = true;
    for (const Level& level : kLevels)
      for (int round = 0; round < level.rounds; ++round, first = false)
        if (!Step(scale * level.sigma_px, level.stiffness, first)) return Result();
    Compare(kMeasured * scale, false);
    return Result();
  }

 private:
  ImageF Composited(const ImageF& layer) const {
    ImageF light(width_, height_, 3);
    for (std::size_t i = 0; i < light.data.size() / 3; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        light.data[3 * i + c] =
            layer.data[4 * i + c] + (1 - layer.data[4 * i + 3]) * frame_.behind.data[3 * i + c];
    return light;
  }

  /// Renders the bent mesh; `made_` and `filmed_` are blurred stored levels.
  void Draw(double sigma_px) {
    const RayScene scene(points_, frame_.character.faces);
    const ImageF layer =
        Blurred(RenderLayer(frame_.character, points_, scene, frame_.gains, frame_.view,
                            frame_.rays, kAlong, frame_.table, frame_.props),
                frame_.blur_px);
    made_ = Blurred(LevelsOf(Composited(layer)), sigma_px);
    filmed_ = Blurred(LevelsOf(frame_.filmed), sigma_px);
    FindFaces(scene, static_cast<int>(std::ceil(2 * sigma_px)));
  }

  void FindFaces(const RayScene& scene, int reach) {
    const std::size_t pixels = static_cast<std::size_t>(width_) * height_;
    faces_ = {std::vector<RayScene::Hit>(pixels), std::vector<std::uint8_t>(pixels, 255)};
    const PixelBox box = ProjectedBounds(points_, frame_.view);
    const Rigid3 world_from_camera = frame_.view.camera_from_world.Inverse();
    const Eigen::Matrix3d turn = world_from_camera.rotation.toRotationMatrix();
    ParallelFor(box.y1 - box.y0, [&](std::int64_t row) {
      for (int x = box.x0; x < box.x1; ++x) {
        const std::size_t i = (box.y0 + row) * width_ + x;
        const Vector3d ray = turn * frame_.rays.At(x, static_cast<int>(box.y0 + row), 0.5, 0.5);
        faces_.hits[i] = scene.Cast(world_from_camera.translation, ray);
        if (faces_.hits[i].face >= 0) faces_.ring[i] = 0;
      }
    });
    for (int ring = 1; ring <= reach; ++ring) Grow(static_cast<std::uint8_t>(ring));
  }

  /// Pixels beside the character take the face of a neighbour, so that outlines pull too.
  void Grow(std::uint8_t ring) {
    std::vector<std::pair<std::size_t, std::size_t>> grown;
    for (int y = 1; y + 1 < height_; ++y)
      for (int x = 1; x + 1 < width_; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * width_ + x;
        if (faces_.ring[i] != 255) continue;
        for (const std::size_t near : {i - 1, i + 1, i - width_, i + width_})
          if (faces_.ring[near] == ring - 1) {
            grown.emplace_back(i, near);
            break;
          }
      }
    for (const auto& [to, from] : grown) {
      faces_.hits[to] = faces_.hits[from];
      faces_.ring[to] = ring;
    }
  }

  bool Counts(std::size_t i) const {
    return faces_.ring[i] != 255 && (frame_.holdout.empty() || frame_.holdout.data[i] == 0);
  }

  /// One Gauss-Newton step. @return false: nothing of the character is seen
  bool Step(double sigma_px, double stiffness, bool first) {
    Draw(sigma_px);
    const Eigen::Index n = 2 * points_.rows();
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    const double evidence = AddPixels(&entries, &right);
    if (!(evidence > 0)) return false;
    AddMembrane(FollowTuning::kStiffness * stiffness * evidence, &entries, &right);
    Eigen::SparseMatrix<double> lower(n, n);
    lower.setFromTriplets(entries.begin(), entries.end());
    if (first) solver_.Analyze(lower);
    solver_.Factor(lower);
    const Eigen::MatrixXd step = solver_.Solve(right);
    for (Eigen::Index v = 0; v < points_.rows(); ++v) {
      Vector2d d(step(2 * v), step(2 * v + 1));
      if (d.norm() > 2 * sigma_px) d *= 2 * sigma_px / d.norm();
      shifts_.row(v) += d.transpose();
    }
    Bend();
    return true;
  }

  /// Sums over pixels are kept for each face: the matrix has all faces' entries, seen or not, so
  /// that its pattern stays.
  double AddPixels(std::vector<Eigen::Triplet<double>>* entries, Eigen::VectorXd* right) {
    const auto& faces = frame_.character.faces;
    std::vector<Eigen::Matrix<double, 6, 6>> sums(static_cast<std::size_t>(faces.rows()),
                                                  Eigen::Matrix<double, 6, 6>::Zero());
    for (int y = 1; y + 1 < height_; ++y)
      for (int x = 1; x + 1 < width_; ++x)
        if (Counts(static_cast<std::size_t>(y) * width_ + x)) AddPixel(x, y, &sums, right);
    double evidence = 0, seen = 0;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
      const auto& sum = sums[f];
      evidence += sum.trace();
      seen += sum.trace() > 0;
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k) {
          const int row = 2 * faces(f, i / 2) + i % 2, column = 2 * faces(f, k / 2) + k % 2;
          if (row >= column) entries->emplace_back(row, column, sum(i, k));
        }
    }
    return seen > 0 ? evidence / seen : 0;
  }

  void AddPixel(int x, int y, std::vector<Eigen::Matrix<double, 6, 6>>* sums,
                Eigen::VectorXd* right) {
    const std::size_t i = static_cast<std::size_t>(y) * width_ + x;
    const RayScene::Hit& hit = faces_.hits[i];
    const double weights[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
    Vector2d pull = Vector2d::Zero();
    double square = 0;
    for (int c = 0; c < 3; ++c) {
      const auto slope = [&](const ImageF& image) {
        return Vector2d(0.5 * (image.at(x + 1, y)[c] - image.at(x - 1, y)[c]),
                        0.5 * (image.at(x, y + 1)[c] - image.at(x, y - 1)[c]));
      };
      const Vector2d g = 0.5 * (slope(made_) + slope(filmed_));
      const double residual = made_.at(x, y)[c] - filmed_.at(x, y)[c];
      products += g * g.transpose();
      pull += residual * g;
      square += residual * residual;
    }
    const double scale2 = 3 * FollowTuning::kOutlier * FollowTuning::kOutlier;
    const double w = std::pow(scale2 / (scale2 + square), 2);
    for (int a = 0; a < 3; ++a) {
      const int v = frame_.character.faces(hit.face, a);
      seen_[v] |= faces_.ring[i] == 0;
      right->segment<2>(2 * v) += w * weights[a] * pull;
      for (int b = 0; b < 3; ++b)
        (*sums)[hit.face].block<2, 2>(2 * a, 2 * b) += w * weights[a] * weights[b] * products;
    }
  }

  /// Of the whole shift, not of the step.
  void AddMembrane(double stiffness, std::vector<Eigen::Triplet<double>>* entries,
                   Eigen::VectorXd* right) const {
    for (const auto& [a, b] : edges_)
      for (int k = 0; k < 2; ++k) {
        const int i = 2 * a + k, j = 2 * b + k;
        entries->emplace_back(i, i, stiffness);
        entries->emplace_back(j, j, stiffness);
        entries->emplace_back(std::max(i, j), std::min(i, j), -stiffness);
        const double pull = stiffness * (shifts_(a, k) - shifts_(b, k));
        (*right)[i] -= pull;
        (*right)[j] += pull;
      }
    for (Eigen::Index v = 0; v < points_.rows(); ++v)
      for (int k = 0; k < 2; ++k) {
        const auto i = static_cast<int>(2 * v + k);
        entries->emplace_back(i, i, kRidge * stiffness + 1e-9);
        (*right)[i] -= kRidge * stiffness * shifts_(v, k);
      }
  }

  /// The mesh with its shifts: pixels at each vertex' own depth.
  void Bend() {
    const Rigid3& camera_from_world = frame_.view.camera_from_world;
    const Eigen::Matrix3d back = camera_from_world.rotation.toRotationMatrix().transpose();
    for (Eigen::Index v = 0; v < points_.rows(); ++v) {
      const Vector3d start = start_.row(v);
      const double depth = (camera_from_world * start).z();
      const Vector3d shift(shifts_(v, 0) * depth / frame_.view.camera.fx,
                           shifts_(v, 1) * depth / frame_.view.camera.fy, 0);
      points_.row(v) = (start + back * shift).transpose();
    }
  }

  void Compare(double sigma_px, bool before) {
    Draw(sigma_px);
    Measure(before);
  }

  void Measure(bool before) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < faces_.ring.size(); ++i)
      if (faces_.ring[i] == 0 && Counts(i))
        for (std::size_t c = 0; c < 3; ++c, ++count) {
          const double d = made_.data[3 * i + c] - filmed_.data[3 * i + c];
          sum += d * d;
        }
    (before ? before_ : after_) = count > 0 ? std::sqrt(sum / count) : 0;
  }

  Followed Result() const {
    Followed result{points_ - start_, 0, 0, before_, after_};
    double count = 0;
    for (Eigen::Index v = 0; v < points_.rows(); ++v) {
      if (!seen_[v]) continue;
      const double size = shifts_.row(v).norm();
      result.mean_px += size;
      result.most_px = std::max(result.most_px, size);
      ++count;
    }
    if (count > 0) result.mean_px /= count;
    return result;
  }

  const FollowedFrame& frame_;
  const PointsX3& start_;
  PointsX3 points_;
  std::vector<std::pair<int, int>> edges_;
  Eigen::Matrix<double, Eigen::Dynamic, 2> shifts_;  // pixels
  std::vector<std::uint8_t> seen_;
  int width_, height_;
  SparseCholesky solver_;
  ImageF made_, filmed_;
  Faces faces_;
  double before_ = 0, after_ = 0;
};

}  // namespace

Followed FollowFilm(const FollowedFrame& frame, const PointsX3& points) {
  return Follower(frame, points).Run();
}

}  // namespace keypose::composite
