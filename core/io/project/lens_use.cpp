#include "core/io/project/lens_use.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/io/pictures/image_kind.h"
#include "core/values/errors.h"

namespace keypose {

void RequireUsableCamera(const Camera& camera, const std::string& where) {
  constexpr double kMost = 1e7,
                   kLeastFocal = 1e-2;  // in pixels; also far above any distortion coefficient
  const std::array<double, 8> numbers{camera.fx, camera.fy, camera.cx, camera.cy,
                                      camera.k1, camera.k2, camera.p1, camera.p2};
  const auto usable = [](double number) { return std::abs(number) <= kMost; };  // false for NaN
  if (!std::all_of(numbers.begin(), numbers.end(), usable) || !(camera.fx > kLeastFocal) ||
      !(camera.fy > kLeastFocal))
    throw InputError(where +
                     " has an impossible focal length, centre or distortion (not finite, 0, or "
                     "beyond 1e7); it is damaged: run sfm again");
  if (camera.width < 1 || camera.height < 1 ||
      std::int64_t{camera.width} * camera.height > kMostPixels)
    throw InputError(where + " is for pictures of " + std::to_string(camera.width) + " x " +
                     std::to_string(camera.height) +
                     " pixels, which is not possible; it is damaged: run sfm again");
}

void RequireUsableLens(const Lens& lens, const std::string& where) {
  constexpr double kMost = 1e7;
  Camera camera = UndistortedCamera(lens);
  camera.fx = lens.fx;
  camera.fy = lens.fy;
  if (camera.width == 0 && camera.height == 0) camera.width = camera.height = 1;
  RequireUsableCamera(camera, where);
  std::vector<double> numbers{lens.skew, lens.p1, lens.p2, lens.p3, lens.p4};
  const auto add = [&](const auto& more) {
    numbers.insert(numbers.end(), more.begin(), more.end());
  };
  add(lens.shape);
  add(lens.radial);
  add(lens.divisor);
  add(lens.prism);
  add(lens.tilt);
  if (!std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::abs(n) <= kMost; }))
    throw InputError(where +
                     " has an impossible distortion (not finite, or beyond 1e7); it is damaged");
}

Camera UsableCamera(const Lens& lens, const std::string& where) {
  RequireUsableLens(lens, where);
  if (const std::optional<Camera> camera = CameraOf(lens)) return *camera;
  throw InputError(where + ": its lens model " + lens.model +
                   " bends the picture in a way that k1, k2, p1, p2 do not hold; undistort the "
                   "pictures first, with "
                   "the program that made the file (`colmap image_undistorter --image_path "
                   "PHOTOGRAPHS --input_path "
                   "MODEL --output_path OUT`; Metashape: Undistort Photos), and use the pictures "
                   "and cameras that it "
                   "writes");
}

void RefuseModel(const std::string& model, const std::string& where) {
  throw InputError(
      where + ": the lens model " + model +
      " is not known; write pictures and cameras of a pinhole with the program that made "
      "them, such as by `colmap image_undistorter`");
}

}  // namespace keypose
