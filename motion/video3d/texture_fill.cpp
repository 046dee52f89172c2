#include "motion/video3d/texture_fill.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3f;

constexpr float kFartherByOne = 0.75f;  // weight of a frame that is farther by one
constexpr float kMeanWeight = 1e-3f;    // of the mean, beside the frames around

Vector3f LinearAt(const TexelColors& colors, std::size_t i) {
  return {LinearOf(colors.color[3 * i]), LinearOf(colors.color[3 * i + 1]),
          LinearOf(colors.color[3 * i + 2])};
}

void Put(TexelColors* colors, std::size_t i, const Vector3f& linear, float sure) {
  for (int c = 0; c < 3; ++c) colors->color[3 * i + c] = SrgbOf(linear[c]);
  colors->sure[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(sure, 0.0f, 1.0f)));
}

TexelColors Sized(std::size_t count) {
  return {std::vector<std::uint8_t>(3 * count), std::vector<std::uint8_t>(count)};
}

float Eased(float t) { return t * t * (3 - 2 * t); }

/// The texture's colours at the listed texels, all sure.
TexelColors ColorsOf(const SurfaceTexels& texels, const Image8& texture) {
  TexelColors colors = Sized(static_cast<std::size_t>(texels.count()));
  for (std::size_t i = 0; i < texels.texel.size(); ++i) {
    std::copy_n(texture.data.data() + 3 * static_cast<std::size_t>(texels.texel[i]), 3,
                colors.color.data() + 3 * i);
    colors.sure[i] = 255;
  }
  return colors;
}

Painting Painted(const SurfaceTexels& texels, const TexelColors& colors, int size) {
  Painting painting(size);
  for (std::size_t i = 0; i < texels.texel.size(); ++i) {
    const auto at = static_cast<std::size_t>(texels.texel[i]);
    painting.At(at) = LinearAt(colors, i);
    painting.sure[at] = colors.sure[i];
  }
  return painting;
}

/// `own`, and `other` in its light where own is not sure.
TexelColors Mixed(const SurfaceTexels& texels, const FacesX3& faces, const LevelFactors& factors,
                  const TexelColors& own, const TexelColors& other) {
  TexelColors mixed = Sized(own.sure.size());
  ParallelBlocks(texels.count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const float sure = static_cast<float>(own.sure[i]) / 255, mine = Eased(sure);
      Vector3f color = LinearAt(own, static_cast<std::size_t>(i));
      if (mine < 1) {
        const Vector3f factor = MeanOfCorners(factors, faces, texels.face[i], texels.weights[i]);
        const Vector3f theirs = Levelled(LinearAt(other, static_cast<std::size_t>(i)), factor);
        color = mine * color + (1 - mine) * theirs;
      }
      const float other_sure = static_cast<float>(other.sure[i]) / 255;
      Put(&mixed, static_cast<std::size_t>(i), color, std::max(sure, other_sure));
    }
  });
  return mixed;
}

}  // namespace

MeanTexture::MeanTexture(const SurfaceTexels& texels)
    : texels_(texels), sum_(4 * static_cast<std::size_t>(texels.count()), 0.0f) {}

void MeanTexture::Add(const TexelColors& frame) {
  ParallelBlocks(texels_.count(), 1 << 15, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const float w = static_cast<float>(frame.sure[i]) / 255;
      if (w <= 0) continue;
      const Vector3f color = LinearAt(frame, static_cast<std::size_t>(i));
      float* sum = sum_.data() + 4 * i;
      for (int c = 0; c < 3; ++c) sum[c] += w * color[c];
      sum[3] += w;
    }
  });
}

double MeanTexture::seen() const {
  std::int64_t count = 0;
  for (std::size_t i = 3; i < sum_.size(); i += 4) count += sum_[i] > 0.5f;
  return texels_.count() > 0 ? static_cast<double>(count) / texels_.count() : 0;
}

TexelColors MeanTexture::Completed(const Mesh& mesh, const Atlas& atlas,
                                   const Image8& own_texture) const {
  TexelColors mean = Sized(static_cast<std::size_t>(texels_.count()));
  for (std::size_t i = 0; i < mean.sure.size(); ++i) {
    const float* sum = sum_.data() + 4 * i;
    if (sum[3] > 0)
      Put(&mean, i, Vector3f(sum[0], sum[1], sum[2]) / sum[3], std::min(1.0f, sum[3]));
  }
  if (!own_texture.empty()) {
    LevelField level(mesh.vertex_count(), mesh.faces, texels_);
    const TexelColors own = ColorsOf(texels_, own_texture);
    mean = Mixed(texels_, mesh.faces, level.Match(mean, own), mean, own);
  }
  Painting painting = Painted(texels_, mean, atlas.size);
  InpaintUnseen(mesh, atlas, painting);
  for (std::size_t i = 0; i < mean.sure.size(); ++i)
    Put(&mean, i, painting.At(static_cast<std::size_t>(texels_.texel[i])),
        static_cast<float>(mean.sure[i]) / 255);
  return mean;
}

TextureFiller::TextureFiller(const Mesh& mesh, const Atlas& atlas, const SurfaceTexels& texels,
                             TexelColors mean, const FillOptions& options)
    : faces_(mesh.faces),
      atlas_(atlas),
      texels_(texels),
      mean_(std::move(mean)),
      options_(options),
      level_(mesh.vertex_count(), mesh.faces, texels) {}

TexelColors TextureFiller::Around(int frame,
                                  const std::function<const TexelColors*(int frame)>& frames,
                                  std::vector<char>* near) const {
  struct Source {
    const TexelColors* colors;
    float weight;
  };
  std::vector<Source> sources;
  for (int way = 1; way <= options_.reach; ++way)
    for (const int other : {frame - way, frame + way})
      if (const TexelColors* colors = frames(other))
        sources.push_back({colors, std::pow(kFartherByOne, static_cast<float>(way))});
  TexelColors around = Sized(mean_.sure.size());
  near->assign(mean_.sure.size(), 0);
  ParallelBlocks(texels_.count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      const auto i = static_cast<std::size_t>(b);
      Vector3f sum = kMeanWeight * LinearAt(mean_, i);
      float total = kMeanWeight, best = static_cast<float>(mean_.sure[i]) / 255;
      for (const Source& source : sources) {
        if (source.colors->sure[i] == 0) continue;
        const float sure = static_cast<float>(source.colors->sure[i]) / 255,
                    w = source.weight * sure * sure;
        sum += w * LinearAt(*source.colors, i);
        total += w;
        best = std::max(best, sure);
      }
      (*near)[i] = total > 2 * kMeanWeight;
      Put(&around, i, sum / total, best);
    }
  });
  return around;
}

FilledTexture TextureFiller::Fill(int frame,
                                  const std::function<const TexelColors*(int frame)>& frames) {
  const TexelColors& own = *frames(frame);
  std::vector<char> near;
  const TexelColors around = Around(frame, frames, &near);
  const LevelFactors& factors = level_.Match(own, around);
  const TexelColors mixed = Mixed(texels_, faces_, factors, own, around);
  FilledTexture filled;
  for (std::size_t i = 0; i < own.sure.size(); ++i) {
    const bool mine = own.sure[i] >= 128;
    filled.own += mine;
    filled.neighbours += !mine && near[i];
  }
  filled.own /= std::max(1, texels_.count());
  filled.neighbours /= std::max(1, texels_.count());
  filled.texture =
      SrgbImage(FinishTexture(atlas_, Painted(texels_, mixed, atlas_.size), options_.gutter));
  return filled;
}

}  // namespace keypose::motion
