// Masks for programs that need pinhole cameras, for the same pixels as the photographs of `colmap
// image_undistorter`.
//
//   undistort_masks MODEL UNDISTORTED_MODEL MASKS OUT [SUFFIX]
//
// Reads MASKS/NAME.png for each view NAME that both models have. Writes OUT/STEM SUFFIX; STEM is
// NAME without its extension, SUFFIX is .png by default. 255 where the interpolated mask is at
// least one half, else 0; 0 outside the photograph.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/colmap_io.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::bench {
namespace {
namespace fs = std::filesystem;

double Interpolated(const Image8& mask, const Eigen::Vector2d& pixel) {
  const double x = pixel.x() - 0.5, y = pixel.y() - 0.5;
  if (!(x > -1 && y > -1 && x < mask.width && y < mask.height)) return 0;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    const int u = x0 + k % 2, v = y0 + k / 2;
    if (u < 0 || v < 0 || u >= mask.width || v >= mask.height) continue;
    sum += (k % 2 ? x - x0 : 1 - x + x0) * (k / 2 ? y - y0 : 1 - y + y0) * *mask.at(u, v);
  }
  return sum;
}

Image8 Undistorted(const Image8& mask, const Camera& from, const Camera& to) {
  Image8 result(to.width, to.height, 1);
  ParallelFor(to.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < to.width; ++x)
      *result.at(x, y) =
          Interpolated(mask, from.Project(to.Unproject({x + 0.5, y + 0.5}))) >= 127.5 ? 255 : 0;
  });
  return result;
}

int Run(const std::vector<std::string>& arguments) {
  if (arguments.size() < 4 || arguments.size() > 5)
    throw UsageError("undistort_masks MODEL UNDISTORTED_MODEL MASKS OUT [SUFFIX]");
  const std::string suffix = arguments.size() == 5 ? arguments[4] : ".png";
  const Scene photographed = ReadColmapModel(arguments[0]),
              undistorted = ReadColmapModel(arguments[1]);
  fs::create_directories(arguments[3]);
  std::size_t from = 0;
  for (const View& view : undistorted.views) {  // both sorted by name
    while (from < photographed.views.size() && photographed.views[from].name < view.name) ++from;
    if (from == photographed.views.size() || photographed.views[from].name != view.name)
      throw InputError(arguments[0] + " has no view '" + view.name + "' that " + arguments[1] +
                       " has; pass the model that was undistorted");
    const Image8 mask = ReadImage(fs::path(arguments[2]) / (view.name + ".png"), 1);
    WritePng(fs::path(arguments[3]) / (fs::path(view.name).stem().string() + suffix),
             Undistorted(mask, photographed.views[from].camera, view.camera));
  }
  return 0;
}

}  // namespace
}  // namespace keypose::bench

int main(int argc, char** argv) {
  try {
    return keypose::bench::Run({argv + 1, argv + argc});
  } catch (const keypose::Error& error) {
    std::fprintf(stderr, "undistort_masks: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
