#include "motion/video3d/picture_difference.h"

#include <algorithm>
#include <cmath>

#include "core/values/errors.h"

namespace keypose::motion {

void PictureDifference::Add(const Image8& render, const Image8& picture, const Image8& mask) {
  constexpr std::uint8_t kOpaque = 255;
  const bool masked = !mask.empty();
  if (render.width != picture.width || render.height != picture.height ||
      (masked && (mask.width != picture.width || mask.height != picture.height)))
    throw InputError("video3d: render, picture and mask have different sizes");
  for (std::size_t p = 0; p < static_cast<std::size_t>(picture.width) * picture.height; ++p) {
    const bool covered = render.data[4 * p + 3] == kOpaque;
    if (masked ? mask.data[p] <= 127 : !covered) continue;
    masked_ += 1;
    if (!covered) continue;
    compared_ += 1;
    for (std::size_t c = 0; c < 3; ++c) {
      const double r = render.data[4 * p + c], q = picture.data[3 * p + c];
      channels_[c].rr += r * r;
      channels_[c].rp += r * q;
      channels_[c].pp += q * q;
    }
  }
}

double PictureDifference::Psnr() const {
  constexpr double kPeak = 255, kLeast = 1e-4;  // of exact pictures: 88 dB
  if (compared_ == 0) return 0;
  double squares = 0;  // of picture - factor * render, with the factor rp / rr
  for (const Channel& channel : channels_)
    squares += channel.pp - (channel.rr > 0 ? channel.rp * channel.rp / channel.rr : 0);
  return 10 * std::log10(kPeak * kPeak / std::max(kLeast, squares / (3 * compared_)));
}

double PictureDifference::Covered() const { return masked_ > 0 ? compared_ / masked_ : 0; }

}  // namespace keypose::motion
