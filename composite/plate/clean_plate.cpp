#include "composite/plate/clean_plate.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/photo.hpp>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"

namespace keypose::composite {
namespace {

constexpr double kGrainLevels = 8;   // stored levels that grain may differ by
constexpr double kUpper = 0.8;       // quantile of the brightest frames
constexpr float kShadowBand = 0.1f;  // frames whose shadow is as weak as the weakest, and this much
// A darker shadow says little of what lies in it, and the less certain its depth, the more of that
// is multiplied.
constexpr float kLeastKept = 0.45f;
constexpr double kPaintRadius = 5;  // [px]

double LevelOf(double light, PlateLight bounds) {
  if (bounds == kBounded) return 255 * SrgbFromLinear(std::clamp(light, 0.0, 1.0));
  return std::isfinite(light) ? 255 * SrgbFromLinear(light) : 0;
}
double LightOf(double level) { return LinearFromSrgb(level / 255); }

struct Sample {
  double level[3];
  double sum;
};

/// What the frames show at a pixel, without their shadows where those are known.
std::vector<Sample> SamplesAt(const std::vector<PlateFrame>& frames, PlateLight bounds, int x,
                              int y) {
  std::vector<Sample> samples;
  float most = 0;
  for (const PlateFrame& frame : frames)
    if (*frame.away.at(x, y) <= 127)
      most = std::max(most, frame.kept.empty() ? 1.0f : *frame.kept.at(x, y));
  for (const PlateFrame& frame : frames) {
    const float kept = frame.kept.empty() ? 1.0f : *frame.kept.at(x, y);
    if (*frame.away.at(x, y) > 127 || kept < most - kShadowBand || kept < kLeastKept) continue;
    Sample sample{};
    for (int c = 0; c < 3; ++c) {
      sample.level[c] = LevelOf(frame.light.at(x, y)[c] / kept, bounds);
      sample.sum += sample.level[c];
    }
    samples.push_back(sample);
  }
  return samples;
}

/// @return number of samples in the mean
int RobustMean(const std::vector<Sample>& samples, bool shadows_known, double* levels) {
  std::vector<double> sums;
  for (const Sample& sample : samples) sums.push_back(sample.sum);
  const double middle = QuantileNearest(std::move(sums), shadows_known ? 0.5 : kUpper);
  int count = 0;
  std::fill_n(levels, 3, 0.0);
  for (const Sample& sample : samples) {
    if (std::abs(sample.sum - middle) > 3 * kGrainLevels) continue;
    for (int c = 0; c < 3; ++c) levels[c] += sample.level[c];
    ++count;
  }
  for (int c = 0; c < 3; ++c) levels[c] /= count;
  return count;
}

/// Paints in what `missing` marks, in stored levels of 16 bits: steps of 8 would show once a
/// picture without grain is graded. OpenCV paints channels of that depth one by one.
void Inpaint(const Image8& missing, PlateLight bounds, ImageF* light) {
  double most = 255;
  if (bounds == kUnbounded)
    for (const float value : light->data) most = std::max(most, LevelOf(value, bounds));
  const double steps = 65535 / most;  // a level in 16 bits
  const cv::Mat mask(missing.height, missing.width, CV_8UC1,
                     const_cast<std::uint8_t*>(missing.data.data()));
  for (int c = 0; c < 3; ++c) {
    cv::Mat stored(missing.height, missing.width, CV_16UC1), painted;
    for (int y = 0; y < missing.height; ++y)
      for (int x = 0; x < missing.width; ++x)
        stored.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(
            std::lround(steps * std::max(0.0, LevelOf(light->at(x, y)[c], bounds))));
    cv::inpaint(stored, mask, painted, kPaintRadius, cv::INPAINT_TELEA);
    for (int y = 0; y < missing.height; ++y)
      for (int x = 0; x < missing.width; ++x)
        if (*missing.at(x, y))
          light->at(x, y)[c] = static_cast<float>(LightOf(painted.at<std::uint16_t>(y, x) / steps));
  }
}

void RequireSizes(const std::vector<PlateFrame>& frames, const ImageF& given) {
  if (frames.empty() && given.empty())
    throw InputError("composite: there is neither a clean plate nor a frame to make one from");
  const ImageF& first = frames.empty() ? given : frames.front().light;
  for (const PlateFrame& frame : frames)
    if (frame.light.width != first.width || frame.light.height != first.height)
      throw InputError("composite: frames of the plate differ in size");
  if (!given.empty() && (given.width != first.width || given.height != first.height))
    throw InputError("composite: the given plate has another size than the frames");
}

}  // namespace

CleanPlate MakeCleanPlate(const std::vector<PlateFrame>& frames, const ImageF& given,
                          PlateLight bounds) {
  RequireSizes(frames, given);
  const int width = frames.empty() ? given.width : frames[0].light.width,
            height = frames.empty() ? given.height : frames[0].light.height;
  CleanPlate plate{ImageF(width, height, 3), ImageF(width, height, 1), 0, 0, 0};
  Image8 missing(width, height, 1);
  const bool known = !frames.empty() && !frames[0].kept.empty();
  ParallelFor(height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const std::vector<Sample> samples = SamplesAt(frames, bounds, x, y);
      if (samples.empty()) {
        *missing.at(x, y) = 255;
        continue;
      }
      double levels[3];
      const int count = RobustMean(samples, known, levels);
      for (int c = 0; c < 3; ++c) plate.light.at(x, y)[c] = static_cast<float>(LightOf(levels[c]));
      *plate.grain_lacking.at(x, y) = 1 - 1 / static_cast<float>(count);
    }
  });
  plate.hidden = static_cast<int>(std::count(missing.data.begin(), missing.data.end(), 255));
  if (plate.hidden == 0) return plate;
  if (given.empty()) {
    Inpaint(missing, bounds, &plate.light);
    plate.inpainted = plate.hidden;
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!*missing.at(x, y)) continue;
      if (given.empty()) {
        *plate.grain_lacking.at(x, y) = 1;
        continue;
      }
      for (int c = 0; c < 3; ++c) plate.light.at(x, y)[c] = given.at(x, y)[c];
      ++plate.given;
    }
  return plate;
}

}  // namespace keypose::composite
