#include "capture/testing/test_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace keypose::capture {
namespace {

double Noise(int x, int y, int seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343U +
                    static_cast<std::uint32_t>(y) * 0xd8163841U +
                    static_cast<std::uint32_t>(seed) * 0xcb1ab31fU;
  h ^= h >> 13;
  h *= 0x85ebca6bU;
  h ^= h >> 16;
  return h / 4294967296.0 - 0.5;
}

std::uint8_t Byte(double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)); }

std::array<double, 3> Wall(int x, int y, int width, int height, TestWall wall) {
  const double u = static_cast<double>(x) / width, v = static_cast<double>(y) / height;
  if (wall == TestWall::kLight) return {205 - 25 * u + 10 * v, 203 - 22 * u + 8 * v, 212 - 12 * u};
  return {28 + 14 * u, 20 + 10 * v, 16 + 5 * u};
}

}  // namespace

Image8 MakeTestWall(int width, int height, TestWall wall) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = Byte(Wall(x, y, width, height, wall)[c] + 3 * Noise(x, y, 90 + c));
  return image;
}

TestPhoto MakeTestPhoto(int index, int width, int height, TestWall wall) {
  TestPhoto photo{Image8(width, height, 3), Image8(width, height, 1)};
  const double angle = 0.4 * index, a = 0.30 * height * (1 + 0.15 * std::sin(index)),
               b = 0.22 * height;
  const double cx = width * (0.5 + 0.03 * std::sin(2.0 * index)), cy = height * 0.52;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double dx = x - cx, dy = y - cy;
      const double p = (std::cos(angle) * dx + std::sin(angle) * dy) / a,
                   q = (-std::sin(angle) * dx + std::cos(angle) * dy) / b;
      const bool inside = p * p + q * q < 1;
      std::array<double, 3> color = Wall(x, y, width, height, wall);
      // Clay of two colours: one very different from the wall, one close to the light wall but
      // grainier.
      if (inside)
        color =
            p > 0.3 ? std::array<double, 3>{222, 214, 196} : std::array<double, 3>{186, 122, 70};
      const double grain = inside ? 34 * (Noise(x / 2, y / 2, index) + Noise(x, y, index + 7))
                                  : 3 * Noise(x, y, index);
      for (int c = 0; c < 3; ++c) photo.image.at(x, y)[c] = Byte(color[c] + grain);
      *photo.truth.at(x, y) = inside ? 255 : 0;
    }
  return photo;
}

Image8 MakeTestStranger(int index, int width, int height, TestWall wall) {
  TestPhoto photo = MakeTestPhoto(index, width, height, wall);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (*photo.truth.at(x, y)) std::swap(photo.image.at(x, y)[0], photo.image.at(x, y)[2]);
  return std::move(photo.image);
}

Image8 Blurred(const Image8& image, int radius) {
  Image8 from = image, to = image;
  for (int pass = 0; pass < 6; ++pass) {
    const bool along_x = pass % 2 == 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < image.channels; ++c) {
          int sum = 0;
          for (int k = -radius; k <= radius; ++k)
            sum += from.at(std::clamp(along_x ? x + k : x, 0, image.width - 1),
                           std::clamp(along_x ? y : y + k, 0, image.height - 1))[c];
          to.at(x, y)[c] = static_cast<std::uint8_t>(sum / (2 * radius + 1));
        }
    std::swap(from, to);
  }
  return from;
}

View MakeTestView(int i, int count, double distance, double rise, int width, int height,
                  double focal_px) {
  const double angle = 2 * M_PI * i / count;
  const Eigen::Vector3d center =
      distance * Eigen::Vector3d(std::cos(angle), std::sin(angle), rise).normalized();
  const Eigen::Vector3d forward = -center.normalized(),
                        right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  View view;
  view.name = "p" + std::to_string(10 + i) + ".png";
  view.camera = {width, height, focal_px, focal_px, width / 2.0, height / 2.0};
  view.camera_from_world.rotation = Eigen::Quaterniond(rotation);
  view.camera_from_world.translation = -(view.camera_from_world.rotation * center);
  return view;
}

}  // namespace keypose::capture
