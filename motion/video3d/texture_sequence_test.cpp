#include "motion/video3d/texture_sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <mutex>

#include "core/pictures/image_quality.h"
#include "core/pictures/render.h"
#include "motion/testing/filmed_ball.h"
#include "motion/video3d/testing/seen_ball.h"

namespace keypose::motion::texture_sequence_test {

using Eigen::Vector3f;

/// Films of the ball, painted, and the held-out camera's picture of it.
struct Sequence : Ball {
  std::map<int, TexelColors> store;
  std::map<int, Image8> textures;
  std::vector<double> gains = std::vector<double>(6, 1.0);
  int ends = 1000;  // frames that camera 1 has

  SequenceReport Make(int frames, const SequenceOptions& options) {
    const SequenceInput input{
        world.mesh,
        world.views,
        frames,
        [this](int f) {
          FilmedFrame frame;
          frame.points = world.Points(f);
          for (std::size_t v = 0; v < world.views.size(); ++v) {
            const bool over = v == 1 && f >= ends;
            frame.pictures.push_back(over ? Image8() : world.Picture(world.views[v], f, gains[v]));
            frame.masks.push_back({});
          }
          return frame;
        },
        {}};
    return MakeTextures(input, options,
                        {[this](int f, const TexelColors& colors) { store[f] = colors; },
                         [this](int f) { return store.at(f); }},
                        [this](int f, const Image8& texture) {
                          static std::mutex mutex;
                          const std::lock_guard<std::mutex> lock(mutex);
                          textures[f] = texture;
                        });
  }
  /// PSNR in the held-out camera, and the share of the background's colour at the rim.
  struct Score {
    double psnr = 0, rim_psnr = 0, halo = 0;
  };
  Score HeldOut(int frame) const {
    Mesh mesh = world.mesh;
    mesh.points = world.Points(frame);
    RenderOptions look;
    look.shading = 0, look.texture = &textures.at(frame);
    const Image8 made = RenderCutout(mesh, RayScene(mesh.points, mesh.faces), world.held_out, look),
                 truth = world.Picture(world.held_out, frame),
                 mask = world.Mask(world.held_out, frame);
    Image8 outside = mask;
    for (std::uint8_t& m : outside.data) m = m ? 0 : 1;
    const ImageF inner = DistanceToEdges(outside, 10);
    double sum = 0, count = 0, rim = 0, rim_count = 0, with = 0, full = 0;
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      if (inner.data[i] < 2 || made.data[4 * i + 3] < 255) continue;
      const bool at_rim = inner.data[i] < 5;
      for (int c = 0; c < 3; ++c) {
        const double off = made.data[4 * i + c] - static_cast<double>(truth.data[3 * i + c]),
                     to_back = 255 * world.background[c] - truth.data[3 * i + c];
        sum += off * off, ++count;
        if (at_rim) rim += off * off, ++rim_count, with += off * to_back, full += to_back * to_back;
      }
    }
    return {Psnr(sum, count), Psnr(rim, rim_count), with / full};
  }
};

TEST_F(Sequence, HeldOutCameraIsPredictedWithoutARimOfBackground) {
  SequenceOptions options;
  options.texture_size = 512;
  const SequenceReport report = Make(2, options);
  ASSERT_EQ(textures.size(), 2u);
  for (const int f : {0, 1}) {
    const Score score = HeldOut(f);
    EXPECT_GT(score.psnr, 36) << f;
    EXPECT_GT(score.rim_psnr, 32) << f;
    EXPECT_LT(std::abs(score.halo), 0.01) << f;
  }
  EXPECT_GT(report.seen_ever, 0.85);  // the ball's top is not
  EXPECT_EQ(report.frames_seen, std::vector<int>(6, 2));
}

TEST_F(Sequence, ExposuresOfCamerasAreLevelled) {
  gains = {1.15, 0.9, 1.05, 0.95, 1.0, 1 / (1.15 * 0.9 * 1.05 * 0.95)};
  SequenceOptions options;
  options.texture_size = 512;
  const SequenceReport report = Make(2, options);
  for (int v = 0; v < 6; ++v)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(report.exposure.gains[v][c] * gains[v], 1, 0.015) << v << " " << c;
  const double levelled = HeldOut(1).psnr;
  EXPECT_GT(levelled, 35);
  options.level_exposure = false;
  Make(2, options);
  EXPECT_LT(HeldOut(1).psnr, levelled - 3);
}

TEST_F(Sequence, FilmThatEndsEarlyLeavesItsPartToTheOthers) {
  ends = 1;
  SequenceOptions options;
  options.texture_size = 512;
  const SequenceReport report = Make(2, options);
  EXPECT_EQ(report.frames_seen[1], 1);
  EXPECT_GT(HeldOut(1).psnr, 32);
}

TEST(AdviseSequenceSize, DoublesWithTheResolutionOfTheFilms) {
  const BallWorld small(6, 160), large(6, 640);
  const int size = AdviseSequenceSize(small.mesh, small.views);
  EXPECT_GE(size, 256);
  EXPECT_EQ(AdviseSequenceSize(large.mesh, large.views), std::min(2048, 4 * size));
}

}  // namespace keypose::motion::texture_sequence_test
