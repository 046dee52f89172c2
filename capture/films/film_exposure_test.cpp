#include "capture/films/film_exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture::film_exposure_test {

TEST(ExposureGains, GiveBackKnownFactorsAlthoughSomethingMoves) {
  std::vector<Image8> frames;
  const double factors[] = {1, 0.8, 1.2, 1, 1};
  for (int i = 0; i < 5; ++i) {
    Image8 frame(120, 90, 3);
    for (std::size_t p = 0; p < frame.data.size(); ++p)
      frame.data[p] = static_cast<std::uint8_t>(std::lround((80 + p * 37 % 90) * factors[i]));
    cv::rectangle(MatOf(frame), cv::Rect(20 * i, 20, 30, 40), cv::Scalar::all(200), -1);
    frames.push_back(frame);
  }
  const std::vector<ExposureGain> gains = ExposureGains(frames);
  for (std::size_t i = 0; i < 5; ++i)
    for (const double gain : gains[i]) EXPECT_NEAR(gain, 1 / factors[i], 0.01) << i;
}

}  // namespace keypose::capture::film_exposure_test
