#include "motion/video3d/texture_fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "motion/video3d/testing/seen_ball.h"

namespace keypose::motion::texture_fill_test {

using Eigen::Vector3f;

TEST_F(Ball, HoleTakesTheColoursOfTheFramesAroundInItsOwnLight) {
  TexelColors bright;
  bright.color.assign(3 * static_cast<std::size_t>(texels.count()), 0);
  bright.sure.assign(static_cast<std::size_t>(texels.count()), 255);
  for (std::size_t i = 0; i < bright.color.size(); ++i)
    bright.color[i] = static_cast<std::uint8_t>(100 + 60 * std::sin(0.01 * static_cast<double>(i)));
  TexelColors dark = bright;
  for (std::uint8_t& c : dark.color) c = static_cast<std::uint8_t>(std::lround(0.7 * c));
  TexelColors torn = dark;  // a cap of the ball is not seen in the dark frame
  std::vector<int> hole;
  for (int i = 0; i < texels.count(); ++i)
    if (world.mesh.points(world.mesh.faces(texels.face[i], 0), 2) > 0.6) {
      hole.push_back(i);
      torn.sure[i] = 0, torn.color[3 * i] = 255;
    }
  ASSERT_GT(hole.size(), 1000u);
  MeanTexture mean(texels);
  mean.Add(bright);
  TextureFiller filler(world.mesh, atlas, texels, mean.Completed(world.mesh, atlas, {}), {});
  const std::map<int, const TexelColors*> frames{{0, &bright}, {1, &torn}};
  const FilledTexture filled = filler.Fill(1, [&](int f) {
    const auto found = frames.find(f);
    return found == frames.end() ? nullptr : found->second;
  });
  double off = 0;
  for (const int i : hole)
    off += std::abs(filled.texture.data[3 * static_cast<std::size_t>(texels.texel[i])] -
                    static_cast<double>(dark.color[3 * static_cast<std::size_t>(i)]));
  EXPECT_LT(off / static_cast<double>(hole.size()), 5);  // of about 75; 32 if not levelled
  EXPECT_NEAR(filled.own + filled.neighbours, 1, 1e-9);
}

TEST_F(Ball, WhatNoFrameShowsIsTheTemplatesTexture) {
  TexelColors seen;
  seen.color.assign(3 * static_cast<std::size_t>(texels.count()), 60);
  seen.sure.assign(static_cast<std::size_t>(texels.count()), 255);
  for (int i = 0; i < texels.count(); ++i)
    if (world.mesh.points(world.mesh.faces(texels.face[i], 0), 2) > 0.6)
      seen.sure[static_cast<std::size_t>(i)] = 0;
  MeanTexture mean(texels);
  mean.Add(seen);
  EXPECT_LT(mean.seen(), 0.9);
  Image8 own(512, 512, 3, 120);  // twice as bright as in the films
  const TexelColors completed = mean.Completed(world.mesh, atlas, own);
  for (int i = 0; i < texels.count(); i += 97)
    EXPECT_NEAR(completed.color[3 * static_cast<std::size_t>(i)], 60, 4) << i;
}

}  // namespace keypose::motion::texture_fill_test
