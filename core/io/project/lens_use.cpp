#include "core/io/project/lens_use.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/io/project/colmap_io.h"
#include "core/values/errors.h"

namespace keypose {

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
