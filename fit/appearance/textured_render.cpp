#include "fit/appearance/textured_render.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr int kTextureLevels = 5;

struct Box {
  int x0, y0, x1, y1;  // half open
};

Box BoundsInPicture(const PointsX3& points, const Pinhole& camera, const Rigid3& pose) {
  const Box all{0, 0, camera.width, camera.height};
  Eigen::Array2d low = Eigen::Array2d::Constant(1e30), high = -low;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d x = pose * points.row(i).transpose();
    if (x.z() <= 0) return all;
    const Eigen::Array2d pixel = camera.Project(x).array();
    low = low.min(pixel);
    high = high.max(pixel);
  }
  const auto clamped = [](double v, int most) {
    return static_cast<int>(std::clamp<double>(v, 0, most));
  };
  return {clamped(std::floor(low.x()), camera.width), clamped(std::floor(low.y()), camera.height),
          clamped(std::ceil(high.x()) + 1, camera.width),
          clamped(std::ceil(high.y()) + 1, camera.height)};
}

}  // namespace

SurfaceTexture::SurfaceTexture(const Mesh& mesh, const Image8& texture) : mesh_(mesh) {
  if (texture.empty()) return;
  pyramid_ = MakeGreyPyramid(texture, kTextureLevels);
  for (Eigen::Index f = 0; f < mesh.uv_faces.rows(); ++f) {
    const Eigen::Vector2d a = mesh.uvs.row(mesh.uv_faces(f, 0)),
                          b = mesh.uvs.row(mesh.uv_faces(f, 1)),
                          c = mesh.uvs.row(mesh.uv_faces(f, 2));
    uv_area_ += std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x()) / 2;
  }
}

int SurfaceTexture::LevelFor(double area, double footprint) const {
  if (blank()) return 0;
  const double texels = pyramid_[0].width * std::sqrt(uv_area_ / std::max(area, 1e-300));
  const double texels_a_pixel = std::max(texels * footprint, 1e-9);
  const int level = static_cast<int>(std::floor(std::log2(texels_a_pixel) + 0.5));
  return std::clamp(level, 0, SizeOf(pyramid_) - 1);
}

float SurfaceTexture::At(int face, double u, double v, int level) const {
  if (blank()) return 0;
  const Eigen::Vector2d uv = (1 - u - v) * mesh_.uvs.row(mesh_.uv_faces(face, 0)) +
                             u * mesh_.uvs.row(mesh_.uv_faces(face, 1)) +
                             v * mesh_.uvs.row(mesh_.uv_faces(face, 2));
  const ImageF& image = pyramid_[level];
  return SampleGrey(image, uv.x() * image.width - 0.5, (1 - uv.y()) * image.height - 0.5);
}

namespace {

TexturedRender BlankRender(const Pinhole& camera) {
  return {ImageT<int>(camera.width, camera.height, 1, -1),
          ImageF(camera.width, camera.height, 1, std::numeric_limits<float>::infinity()),
          ImageF(camera.width, camera.height, 1)};
}

/// Calls `hit_pixel` for what is hit, after face and depth are written.
template <class HitPixel>
TexturedRender CastPixels(const PointsX3& points, const RayScene& scene, const Pinhole& camera,
                          const Rigid3& camera_from_world, const HitPixel& hit_pixel) {
  TexturedRender render = BlankRender(camera);
  const Eigen::Matrix3d turn = camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d eye = camera_from_world.Inverse().translation;
  const Box box = BoundsInPicture(points, camera, camera_from_world);
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      // the ray has z = 1 in the camera's frame, so its length is the depth
      const RayScene::Hit hit = scene.Cast(eye, turn * camera.Ray(x, y));
      if (hit.face < 0) continue;
      *render.face.at(x, y) = hit.face;
      *render.depth.at(x, y) = static_cast<float>(hit.distance);
      hit_pixel(hit, render.grey.at(x, y));
    }
  return render;
}

}  // namespace

TexturedRender RenderGrey(const PointsX3& points, const FacesX3& faces,
                          const SurfaceTexture& texture, int texture_level, const RayScene& scene,
                          const Pinhole& camera, const Rigid3& camera_from_world) {
  if (faces.rows() == 0) return BlankRender(camera);
  return CastPixels(points, scene, camera, camera_from_world,
                    [&](const RayScene::Hit& hit, float* grey) {
                      *grey = texture.At(hit.face, hit.u, hit.v, texture_level);
                    });
}

TexturedRender RenderShape(const PointsX3& points, const RayScene& scene, const Pinhole& camera,
                           const Rigid3& camera_from_world) {
  return CastPixels(points, scene, camera, camera_from_world, [](const RayScene::Hit&, float*) {});
}

double Overlap(const TexturedRender& render, const GreyMask& mask) {
  std::int64_t both = 0, either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const bool hit = render.face.data[i] >= 0, inside = InMask(mask.data[i]);
    both += hit && inside;
    either += hit || inside;
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

}  // namespace keypose::fit
