#include "export/animation/texture_blend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

/// Tolerance of weights; smaller than one level of an 8 bit colour.
constexpr double kSameWeight = 1e-6;

bool OnTheLine(const TextureMoment& a, const TextureMoment& b, const TextureMoment& c) {
  const double share = (b.seconds - a.seconds) / (c.seconds - a.seconds);
  for (std::size_t k = 0; k < b.weights.size(); ++k)
    if (std::abs(a.weights[k] + share * (c.weights[k] - a.weights[k]) - b.weights[k]) > kSameWeight)
      return false;
  return true;
}

}  // namespace

std::vector<double> TextureWeights(double t, const std::vector<int>& key_textures, int count) {
  std::vector<double> weights(count, 0.0);
  const int last = SizeOf(key_textures) - 1;
  const int key = std::clamp(static_cast<int>(std::floor(t)), 0, last);
  const double share = std::clamp(t - key, 0.0, 1.0);
  weights[key_textures[key]] += 1 - share;
  weights[key_textures[std::min(key + 1, last)]] += share;
  return weights;
}

std::vector<TextureMoment> TextureMoments(const std::vector<Keyframe>& keyframes,
                                          const std::vector<double>& frame_t,
                                          const std::vector<int>& key_textures, int count) {
  std::vector<TextureMoment> moments;
  for (const Keyframe& keyframe : keyframes) {
    TextureMoment moment{keyframe.seconds,
                         TextureWeights(frame_t[keyframe.frame], key_textures, count)};
    if (moments.size() >= 2 && OnTheLine(moments[moments.size() - 2], moments.back(), moment))
      moments.pop_back();
    moments.push_back(std::move(moment));
  }
  return moments;
}

}  // namespace keypose::exporting
