#include "reconstruct/testing/rendered_ring.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct::testing {
namespace {

std::uint64_t Hash(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}
double Unit(std::uint64_t hash) { return static_cast<double>(hash >> 11) * 0x1p-53; }

double Lattice(int x, int y, int z) {
  return Unit(Hash((static_cast<std::uint64_t>(x + 4096) << 42) ^
                   (static_cast<std::uint64_t>(y + 4096) << 21) ^
                   static_cast<std::uint64_t>(z + 4096) ^ 0x9E3779B97F4A7C15ull));
}

// Value noise in [0,1], smooth.
double Noise(const Eigen::Vector3d& p) {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y())),
            z = static_cast<int>(std::floor(p.z()));
  auto fade = [](double t) { return t * t * (3 - 2 * t); };
  const double fx = fade(p.x() - x), fy = fade(p.y() - y), fz = fade(p.z() - z);
  double sum = 0;
  for (int k = 0; k < 8; ++k)
    sum += Lattice(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)) * ((k & 1) ? fx : 1 - fx) *
           ((k >> 1 & 1) ? fy : 1 - fy) * ((k >> 2) ? fz : 1 - fz);
  return sum;
}

double Paint(const Eigen::Vector3d& p) {
  return (Noise(p * 9) + Noise(p * 19) + Noise(p * 41)) / 1.5 - 1;
}

double Radius(const Eigen::Vector3d& d) {
  const double dent =
      std::exp(-8 * (d - Eigen::Vector3d(0.8, -0.5, 0.33).normalized()).squaredNorm());
  return 1 + 0.15 * std::sin(3.1 * d.x() + 0.4) * std::sin(2.7 * d.y() - 0.8) +
         0.08 * std::sin(5 * d.z()) - 0.2 * dent;
}

Mesh LumpyBall(int rings) {
  const int columns = 2 * rings;
  Mesh mesh;
  mesh.points.resize(rings * columns + 2, 3);
  auto put = [&](int i, double theta, double phi) {
    const Eigen::Vector3d d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                            std::cos(theta));
    mesh.points.row(i) = d * Radius(d);
  };
  for (int r = 0; r < rings; ++r)
    for (int c = 0; c < columns; ++c)
      put(r * columns + c, M_PI * (r + 1) / (rings + 1), 2 * M_PI * c / columns);
  const int top = rings * columns, bottom = top + 1;
  put(top, 0, 0), put(bottom, M_PI, 0);
  std::vector<Eigen::Vector3i> faces;
  for (int c = 0; c < columns; ++c) {
    const int n = (c + 1) % columns;
    faces.emplace_back(top, c, n);
    faces.emplace_back(bottom, (rings - 1) * columns + n, (rings - 1) * columns + c);
    for (int r = 0; r + 1 < rings; ++r) {
      faces.emplace_back(r * columns + c, (r + 1) * columns + c, (r + 1) * columns + n);
      faces.emplace_back(r * columns + c, (r + 1) * columns + n, r * columns + n);
    }
  }
  mesh.faces.resize(SizeOf(faces), 3);
  for (std::size_t i = 0; i < faces.size(); ++i) mesh.faces.row(static_cast<int>(i)) = faces[i];
  return mesh;
}

View RingView(int i, const RingOptions& options) {
  const double azimuth = 2 * M_PI * (i % options.views) / options.views + (i / options.views) * 0.1;
  const double elevation = (i < options.views ? 15 : 45) * M_PI / 180;
  const Eigen::Vector3d eye =
      6 * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                          std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  View view;
  view.name = "view_" + std::to_string(100 + i) + ".png";
  view.camera.width = view.camera.height = options.size;
  view.camera.fx = view.camera.fy = 1.9 * options.size;
  view.camera.cx = 0.5 * options.size + 1.3, view.camera.cy = 0.5 * options.size - 0.7;
  view.camera.k1 = options.k1;
  view.camera_from_world = LookAt(eye, Eigen::Vector3d::Zero());
  return view;
}

void Shoot(const RayScene& rays, const Mesh& mesh, const PointsX3& normals,
           const RingOptions& options, const View& view, std::uint64_t seed, Image8* image,
           Image8* mask) {
  constexpr int kSub = 3;
  *image = Image8(options.size, options.size, 3, 20);
  *mask = Image8(options.size, options.size, 1);
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d center = view.Center();
  for (int y = 0; y < options.size; ++y)
    for (int x = 0; x < options.size; ++x) {
      int hits = 0;
      double sum = 0;
      for (int k = 0; k < kSub * kSub; ++k) {
        const Eigen::Vector2d pixel(x + (k % kSub + 0.5) / kSub, y + (k / kSub + 0.5) / kSub);
        const Eigen::Vector3d ray = world_from_camera * view.camera.Unproject(pixel);
        const RayScene::Hit hit = rays.Cast(center, ray);
        if (hit.face < 0) continue;
        ++hits;
        double light = 1;
        if (options.shaded) {
          const Eigen::Vector3d n = (1 - hit.u - hit.v) * normals.row(mesh.faces(hit.face, 0)) +
                                    hit.u * normals.row(mesh.faces(hit.face, 1)) +
                                    hit.v * normals.row(mesh.faces(hit.face, 2));
          light = 0.4 + 0.6 * std::max(0.0, -n.normalized().dot(ray.normalized()));
        }
        sum += light * (130 + options.contrast * Paint(center + hit.distance * ray));
      }
      if (hits * 2 > kSub * kSub) *mask->at(x, y) = 255;
      const std::uint64_t id =
          Hash(seed * 0x9E3779B97F4A7C15ull + static_cast<std::uint64_t>(y) * 65536 + x);
      const double gauss =
          std::sqrt(-2 * std::log(1 - Unit(id))) * std::cos(2 * M_PI * Unit(Hash(id)));
      const double grey = hits ? (sum + 20.0 * (kSub * kSub - hits)) / (kSub * kSub) : 20;
      for (int c = 0; c < 3; ++c)
        image->at(x, y)[c] = static_cast<std::uint8_t>(
            std::lround(std::clamp(grey + options.noise * gauss, 0.0, 255.0)));
    }
}

}  // namespace

RenderedScene RenderRing(const RingOptions& options) {
  RenderedScene out;
  out.truth = LumpyBall(200);
  const RayScene rays(out.truth.points, out.truth.faces);
  const PointsX3 normals = VertexNormals(out.truth.points, out.truth.faces);
  const int count = 2 * options.views;
  for (int i = 0; i < count; ++i) out.scene.views.push_back(RingView(i, options));
  out.images.resize(count), out.masks.resize(count);
  ParallelFor(count, [&](std::int64_t i) {
    Shoot(rays, out.truth, normals, options, out.scene.views[i], static_cast<std::uint64_t>(i) + 1,
          &out.images[i], &out.masks[i]);
  });
  out.footprint = 5.0 / (1.9 * options.size);
  return out;
}

std::vector<PreparedView> Prepared(const RenderedScene& rendered, int levels) {
  std::vector<PreparedView> views;
  for (std::size_t i = 0; i < rendered.images.size(); ++i) {
    const int index = static_cast<int>(i);
    const Image8 &image = rendered.images[i], &mask = rendered.masks[i];
    views.push_back(PrepareView(rendered.scene.views[i], index, image, mask, 1.0, levels));
  }
  return views;
}

Accuracy Measure(const RenderedScene& rendered, const PointCloud& cloud, int count) {
  Accuracy accuracy;
  if (count == 0) return accuracy;
  const RayScene rays(rendered.truth.points, rendered.truth.faces);
  const PointsX3 face_normals = FaceNormals(rendered.truth.points, rendered.truth.faces);
  std::vector<double> errors(count), angles(count);
  ParallelFor(count, [&](std::int64_t i) {
    const RayScene::Foot foot = rays.ClosestPoint(cloud.points.row(i));
    errors[i] = std::sqrt(foot.squared_distance) / rendered.footprint;
    angles[i] =
        std::acos(std::clamp(face_normals.row(foot.face).dot(cloud.normals.row(i)), -1.0, 1.0)) *
        180 / M_PI;
  });
  for (const double angle : angles) accuracy.normal_deg_mean += angle / count;
  accuracy.outliers = static_cast<double>(std::count_if(errors.begin(), errors.end(),
                                                        [](double e) { return e > 5; })) /
                      count;
  accuracy.footprints_90 = QuantileFloor(std::move(errors), 0.9);
  const KdTree tree(cloud.points.topRows(count));
  const SurfaceSamples samples =
      SampleSurface(rendered.truth.points, rendered.truth.faces, 5000, 7);
  int seen = 0, near = 0;
  for (int i = 0; i < samples.points.rows(); ++i) {
    if (face_normals(samples.faces[i], 2) < -0.3)
      continue;  // the underside, which cameras above see at a grazing angle at best
    ++seen;
    near += tree.Nearest(Eigen::Vector3d(samples.points.row(i))).squared_distance <
            std::pow(3 * rendered.footprint, 2);
  }
  accuracy.completeness = static_cast<double>(near) / std::max(1, seen);
  return accuracy;
}

std::vector<std::vector<int>> AllOthers(int count) {
  std::vector<std::vector<int>> sources(count);
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < count; ++k)
      if (k != i) sources[i].push_back(k);
  return sources;
}

}  // namespace keypose::reconstruct::testing
