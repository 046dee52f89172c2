#include "export/gltf/gltf.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "export/animation/testing/boxes.h"

namespace keypose::exporting::gltf_test {

const EncodedImage kTexture{"any bytes at all, only carried", "image/png", "clay"};

// An independent reader of the file layout: header, JSON chunk, binary chunk.
struct Glb {
  nlohmann::json json;
  std::string binary;

  explicit Glb(const std::string& bytes) {
    const auto word = [&](std::size_t at) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + at, 4);
      return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2u);
    EXPECT_EQ(word(8), bytes.size());
    json = nlohmann::json::parse(bytes.substr(20, word(12)));
    const std::size_t at = 20 + word(12);
    binary = bytes.substr(at + 8, word(at));
  }

  Eigen::MatrixXf Read(int accessor) const {
    const auto& a = json["accessors"][accessor];
    const auto& view = json["bufferViews"][a["bufferView"].get<int>()];
    const int columns = a["type"] == "VEC3" ? 3 : a["type"] == "VEC2" ? 2 : 1;
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> out(a["count"].get<int>(),
                                                                              columns);
    std::memcpy(out.data(), binary.data() + view.value("byteOffset", 0),
                sizeof(float) * out.size());
    return out;
  }
  Eigen::VectorXi ReadIndices(int accessor) const {
    const auto& a = json["accessors"][accessor];
    Eigen::VectorXi out(a["count"].get<int>());
    std::memcpy(
        out.data(),
        binary.data() + json["bufferViews"][a["bufferView"].get<int>()].value("byteOffset", 0),
        4 * out.size());
    return out;
  }
};

GlbTextures OneTexture(const EncodedImage& image) { return {{image}, {"rest"}, {}}; }

Glb Written(const std::vector<Mesh>& frames, const EncodedImage& texture = kTexture,
            const GlbOptions& options = {}) {
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(frames.size()));
  return Glb(MakeGlb(mesh, MakeClip(mesh.points, {}, false), Names(frames.size()),
                     OneTexture(texture), options));
}

TEST(MakeGlb, MorphTargetsMoveTheBaseToEachFrameWithYUp) {
  const auto frames = StretchingBox(4);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(4));
  const Glb glb = Written(frames);
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  ASSERT_EQ(primitive["targets"].size(), 3u);
  const Eigen::MatrixXf base = glb.Read(primitive["attributes"]["POSITION"]);
  for (int i = 1; i < 4; ++i) {
    const Eigen::MatrixXf moved = base + glb.Read(primitive["targets"][i - 1]["POSITION"]);
    for (Eigen::Index v = 0; v < base.rows(); ++v) {
      const Eigen::Vector3d p = mesh.points[i].row(v);
      EXPECT_LT((moved.row(v).transpose() - Eigen::Vector3f(p.x(), p.z(), -p.y())).norm(), 1e-6)
          << "frame " << i << " vertex " << v;
    }
  }
  EXPECT_EQ(glb.json["meshes"][0]["extras"]["targetNames"],
            nlohmann::json({"frame_0001", "frame_0002", "frame_0003"}));
}

TEST(MakeGlb, NormalTargetsLeadToTheNormalsOfTheFrame) {
  const auto frames = StretchingBox(2);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(2));
  GlbOptions options;
  options.z_up = false;
  const Glb glb = Written(frames, kTexture, options);
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const Eigen::MatrixXf normals =
      glb.Read(primitive["attributes"]["NORMAL"]) + glb.Read(primitive["targets"][0]["NORMAL"]);
  EXPECT_LT((normals - mesh.normals[1].cast<float>()).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(MakeGlb, TurningTheAxesKeepsOutsideOutside) {
  const Glb glb = Written(StretchingBox(1));
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const PointsX3 points = glb.Read(primitive["attributes"]["POSITION"]).cast<double>();
  const Eigen::VectorXi indices = glb.ReadIndices(primitive["indices"]);
  FacesX3 faces(indices.size() / 3, 3);
  std::copy(indices.begin(), indices.end(), faces.data());
  EXPECT_NEAR(SignedVolume(points, faces), 6, 1e-6);
}

TEST(MakeGlb, BoundsAreThoseOfTheWrittenValues) {
  const Glb glb = Written(StretchingBox(3));
  int with_bounds = 0;
  for (std::size_t a = 0; a < glb.json["accessors"].size(); ++a) {
    const auto& accessor = glb.json["accessors"][a];
    if (!accessor.contains("min")) continue;
    ++with_bounds;
    const Eigen::MatrixXf values = glb.Read(static_cast<int>(a));
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      EXPECT_EQ(accessor["min"][c].get<float>(), values.col(c).minCoeff());
      EXPECT_EQ(accessor["max"][c].get<float>(), values.col(c).maxCoeff());
    }
  }
  EXPECT_EQ(with_bounds, 4);  // base, two targets, times
}

TEST(MakeGlb, TextureBytesAreCarriedAndVPointsDown) {
  const auto frames = StretchingBox(1);
  const AnimatedMesh mesh = MakeAnimatedMesh(frames, Names(1));
  const Glb glb = Written(frames);
  const auto& image = glb.json["images"][0];
  const auto& view = glb.json["bufferViews"][image["bufferView"].get<int>()];
  EXPECT_EQ(glb.binary.substr(view["byteOffset"], view["byteLength"]), kTexture.bytes);
  EXPECT_EQ(image["mimeType"], "image/png");
  const Eigen::MatrixXf uvs =
      glb.Read(glb.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]);
  EXPECT_LT((uvs.col(1).array() - (1 - mesh.uvs.col(1).cast<float>().array())).abs().maxCoeff(),
            1e-7);
}

TEST(MakeGlb, EachMomentShowsExactlyItsFrame) {
  GlbOptions options;
  options.playback = {10, 2, "pingpong"};
  const Glb glb = Written(StretchingBox(3), kTexture, options);
  const auto& sampler = glb.json["animations"][0]["samplers"][0];
  const Eigen::MatrixXf times = glb.Read(sampler["input"]), flat = glb.Read(sampler["output"]);
  // 0 0' 1 2 2' 1 0, with two held frames at both ends
  const std::vector<double> expected_times{0, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8};
  const std::vector<int> expected_frames{0, 0, 1, 2, 2, 1, 0};
  ASSERT_EQ(times.rows(), 7);
  ASSERT_EQ(flat.rows(), 14);
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(times(i, 0), expected_times[i], 1e-6);
    EXPECT_EQ(flat(2 * i, 0), expected_frames[i] == 1 ? 1 : 0);
    EXPECT_EQ(flat(2 * i + 1, 0), expected_frames[i] == 2 ? 1 : 0);
  }
}

TEST(MakeGlb, OneFrameHasNeitherTargetsNorAnimation) {
  const Glb glb = Written(StretchingBox(1));
  EXPECT_FALSE(glb.json.contains("animations"));
  EXPECT_FALSE(glb.json["meshes"][0]["primitives"][0].contains("targets"));
}

TEST(MakeGlb, TextureWithoutCoordinatesThrowsInputError) {
  const AnimatedMesh mesh = MakeAnimatedMesh({MakeIcosphere(1)}, Names(1));
  const Clip clip = MakeClip(mesh.points, {}, false);
  EXPECT_THROW(MakeGlb(mesh, clip, Names(1), OneTexture(kTexture), {}), InputError);
  EXPECT_NO_THROW(MakeGlb(mesh, clip, Names(1), {}, {}));
}

std::string BytesOf(int count) {
  const AnimatedMesh mesh = MakeAnimatedMesh(StretchingBox(count), Names(count));
  return MakeGlb(mesh, MakeClip(mesh.points, {}, false), Names(count), OneTexture(kTexture), {});
}

TEST(MakeGlb, SameBytesForAnyThreadCount) {
  SetThreadCount(1);
  const auto one = BytesOf(5);
  SetThreadCount(4);
  const auto four = BytesOf(5);
  SetThreadCount(0);
  EXPECT_EQ(one, four);
}

// The target weights that a player uses at a time, by glTF 2.0, appendix C.
std::vector<double> WeightsAt(const Glb& glb, double seconds) {
  const auto& sampler = glb.json["animations"][0]["samplers"][0];
  const Eigen::MatrixXf times = glb.Read(sampler["input"]), flat = glb.Read(sampler["output"]);
  const Eigen::Index count = flat.rows() / times.rows();
  Eigen::Index i = 0;
  while (i + 1 < times.rows() && times(i + 1, 0) <= seconds) ++i;
  const Eigen::Index next = std::min(i + 1, times.rows() - 1);
  const bool steps = sampler["interpolation"] == "STEP" || next == i || seconds < times(0, 0);
  const double share = steps ? 0 : (seconds - times(i, 0)) / (times(next, 0) - times(i, 0));
  std::vector<double> weights;
  for (Eigen::Index k = 0; k < count; ++k)
    weights.push_back((1 - share) * flat(i * count + k, 0) + share * flat(next * count + k, 0));
  return weights;
}

// The height at any time, from the weights of the targets.
double HeightAt(const Glb& glb, const std::vector<double>& height_of_target, double seconds) {
  const std::vector<double> weights = WeightsAt(glb, seconds);
  double height = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) height += weights[k] * height_of_target[k];
  return height;
}

TEST(MakeGlb, OnTwosEveryPictureStandsUntilTheNext) {
  // On twos from key 0 over five frames to key 5, which repeats the first picture: 0 0 2 2 4 0.
  const AnimatedMesh mesh = Boxes({0, 0, 2, 2, 4, 0});
  const Clip clip = MakeClip(mesh.points, {1, 1, 1, 1, 1, 0}, false);
  GlbOptions options;
  options.playback.fps = 10;
  const Glb glb(MakeGlb(mesh, clip, Names(6), {}, options));
  EXPECT_EQ(glb.json["meshes"][0]["extras"]["targetNames"],
            nlohmann::json({"frame_0002", "frame_0004"}))
      << "no picture twice";
  EXPECT_EQ(glb.json["animations"][0]["samplers"][0]["interpolation"], "STEP");
  const std::vector<double> expected{0, 0, 2, 2, 4, 0};
  for (int i = 0; i < 595; ++i) {
    const double seconds = (i + 0.5) / 1000;
    EXPECT_EQ(HeightAt(glb, {2, 4}, seconds), expected[static_cast<int>(seconds * 10)])
        << seconds << " s";
  }
}

// Players ask at n / fps in double precision, and the times in the file are single ones.
TEST(MakeGlb, AskedAtAFramesTimeItShowsThatFrame) {
  constexpr int kFrames = 480;
  std::vector<int> heights(kFrames);
  std::iota(heights.begin(), heights.end(), 0);
  const AnimatedMesh mesh = Boxes(heights);
  const std::vector<double> targets(heights.begin() + 1, heights.end());
  for (const double fps : {12.0, 24.0, 24000 / 1001.0, 25.0, 29.97, 60.0}) {
    GlbOptions options;
    options.playback.fps = fps;
    const Glb steps(MakeGlb(mesh, MakeClip(mesh.points, std::vector<char>(kFrames, 1), false),
                            Names(kFrames), {}, options));
    const Glb glides(MakeGlb(mesh, MakeClip(mesh.points, std::vector<char>(kFrames, 0), false),
                             Names(kFrames), {}, options));
    std::vector<char> on_twos(kFrames, 0);
    for (int i = 0; i < kFrames; ++i) on_twos[i] = i % 24 != 23;
    const Glb mixed(
        MakeGlb(mesh, MakeClip(mesh.points, on_twos, false), Names(kFrames), {}, options));
    for (int n = 0; n + 1 < kFrames; ++n) {
      ASSERT_EQ(HeightAt(steps, targets, n / fps), n) << fps;
      ASSERT_NEAR(HeightAt(glides, targets, n / fps), n, 1e-3) << fps;
      ASSERT_NEAR(HeightAt(mixed, targets, n / fps), n, 1e-3) << fps;
    }
  }
}

TEST(MakeGlb, TheAnimationHasAnotherNameThanTheNode) {
  const Glb glb = Written(StretchingBox(3));
  EXPECT_NE(glb.json["animations"][0]["name"], glb.json["nodes"][0]["name"]);
}

TEST(MakeGlb, GlidesAndStepsInOneClipPlayAsEach) {
  // A hold of the first picture, a blend to 3, two pictures on twos, and a blend from the last of
  // them.
  const AnimatedMesh mesh = Boxes({0, 0, 0, 1, 2, 3, 3, 5, 5, 6, 7});
  const std::vector<char> stands{0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0};
  const Clip clip = MakeClip(mesh.points, stands, false);
  GlbOptions options;
  options.playback.fps = 10;
  const Glb glb(MakeGlb(mesh, clip, Names(11), {}, options));
  EXPECT_EQ(glb.json["meshes"][0]["primitives"][0]["targets"].size(), 6u);
  const auto& sampler = glb.json["animations"][0]["samplers"][0];
  EXPECT_EQ(sampler["interpolation"], "LINEAR");
  const Eigen::MatrixXf times = glb.Read(sampler["input"]);
  for (Eigen::Index i = 1; i < times.rows(); ++i)
    EXPECT_GT(times(i, 0), times(i - 1, 0)) << "times must rise strictly";
  const std::vector<double> height{0, 0, 0, 1, 2, 3, 3, 5, 5, 6, 7};
  for (int i = 0; i < 1000; ++i) {
    const double frame = (i + 0.5) / 100;
    const int before = static_cast<int>(frame);
    if (stands[before] && frame - before > 0.998) continue;  // the step itself
    const double expected =
        stands[before] ? height[before]
                       : height[before] + (frame - before) * (height[before + 1] - height[before]);
    EXPECT_NEAR(HeightAt(glb, {1, 2, 3, 5, 6, 7}, frame / 10), expected, 1e-4) << "frame " << frame;
  }
}

TEST(MakeGlb, TexturesOfAllPosesAreNamedInTheMaterialAndTheFirstIsTheBaseColour) {
  const AnimatedMesh mesh = Boxes({0, 1});
  GlbTextures textures{{kTexture, {"other bytes", "image/jpeg", "bent"}},
                       {"rest", "bent"},
                       {{0, {1, 0}}, {0.5, {0, 1}}}};
  const Glb glb(MakeGlb(mesh, MakeClip(mesh.points, {}, false), Names(2), textures, {}));
  const auto& material = glb.json["materials"][0];
  EXPECT_EQ(material["pbrMetallicRoughness"]["baseColorTexture"].value("index", 0), 0);
  const auto& blend = material["extras"]["keypose"];
  EXPECT_EQ(blend["poses"], nlohmann::json({"rest", "bent"}));
  EXPECT_EQ(blend["textures"], nlohmann::json({0, 1}));
  EXPECT_EQ(blend["moments"][1]["seconds"], 0.5);
  EXPECT_EQ(blend["moments"][1]["weights"], nlohmann::json({0.0, 1.0}));
  const auto& view = glb.json["bufferViews"][glb.json["images"][1]["bufferView"].get<int>()];
  EXPECT_EQ(glb.binary.substr(view["byteOffset"], view["byteLength"]), "other bytes");
}

}  // namespace keypose::exporting::gltf_test
