// The GLB with few morph targets: decoded by hand, in three.js, in Blender, and by the validator.
#include "export/gltf/few_targets.h"
#include "core/testing/paths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "export/caches/testing/run_reader.h"
#include "export/caches/testing/test_scene.h"

namespace keypose::exporting::few_targets_test {

namespace fs = std::filesystem;

Scene SceneOf(std::vector<Mesh> frames, std::vector<char> stands = {},
              const PlaybackOptions& playback = {10, 0, "none"}) {
  Scene scene;
  for (std::size_t i = 0; i < frames.size(); ++i)
    scene.frame_names.push_back("frame_" + std::to_string(i));
  scene.frames = std::move(frames);
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  scene.clip = MakeClip(scene.split.points, std::move(stands), false);
  scene.playback = playback;
  return scene;
}

/// A tube of length 4 along z. Its middle unit bends to a circle's arc, the rest follows.
Mesh Limb(double angle_rad) {
  Mesh limb = MakeCylinder(0.3, 4, 20, 40);
  limb.points.col(2).array() -= limb.points.col(2).minCoeff();
  if (angle_rad == 0) return limb;
  for (int v = 0; v < limb.vertex_count(); ++v) {
    const double x = limb.points(v, 0), along = limb.points(v, 2) - 1.5;
    const double bent = std::clamp(along, 0.0, 1.0), turn = angle_rad * bent;
    const double before = std::min(along, 0.0), after = std::max(along - 1, 0.0);
    limb.points(v, 0) =
        (1 - std::cos(turn)) / angle_rad + std::sin(turn) * after + std::cos(turn) * x;
    limb.points(v, 2) =
        1.5 + std::sin(turn) / angle_rad + std::cos(turn) * after + before - std::sin(turn) * x;
  }
  return limb;
}

/// Frames of a limb that bends by 120 degrees.
std::vector<Mesh> BendingLimb(int count) {
  std::vector<Mesh> frames;
  for (int i = 0; i < count; ++i)
    frames.push_back(Limb(i / (count - 1.0) * 120 * std::numbers::pi / 180));
  return frames;
}

/// A sphere whose bands turn and shift at speeds of their own: no eight shapes can follow.
std::vector<Mesh> WrithingSphere(int count) {
  const Mesh sphere = MakeIcosphere(3);
  std::vector<Mesh> frames(count, sphere);
  for (int i = 0; i < count; ++i) {
    for (int v = 0; v < sphere.vertex_count(); ++v) {
      const double x = sphere.points(v, 0), y = sphere.points(v, 1), z = sphere.points(v, 2);
      const double turn = 0.25 * i * std::sin(7 * z), shift = 0.2 * std::sin(1.7 * i * (1 + z));
      frames[i].points.row(v) << std::cos(turn) * x - std::sin(turn) * y + shift,
          std::sin(turn) * x + std::cos(turn) * y, z + 0.1 * std::cos(0.9 * i * x);
    }
  }
  return frames;
}

/// A box that goes once around a circle and ends where it began.
std::vector<Mesh> CirclingBox(int count) {
  std::vector<Mesh> frames(count, MakeBox(1, 2, 3));
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / (count - 1);
    frames[i].points.rowwise() += Eigen::RowVector3d(std::cos(angle), 0, std::sin(angle));
  }
  frames.back() = frames.front();
  return frames;
}

/// What a player knows of the file: an independent reader of its layout.
class Player {
 public:
  explicit Player(const std::string& bytes) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    json_ = nlohmann::json::parse(bytes.substr(20, size));
    binary_ = bytes.substr(28 + size);
    const auto& primitive = json_["meshes"][0]["primitives"][0];
    base_ = Read(primitive["attributes"]["POSITION"], 3);
    for (const auto& target : primitive.value("targets", nlohmann::json::array()))
      targets_.push_back(Read(target["POSITION"], 3));
    if (!json_.contains("animations")) return;
    const auto& sampler = json_["animations"][0]["samplers"][0];
    EXPECT_EQ(sampler["interpolation"], "LINEAR");
    times_ = Read(sampler["input"], 1);
    weights_ = Read(sampler["output"], target_count());
  }

  const nlohmann::json& json() const { return json_; }
  const Eigen::MatrixXd& base() const { return base_; }
  const Eigen::MatrixXd& target(int k) const { return targets_[k]; }
  const Eigen::MatrixXd& weights() const { return weights_; }
  int target_count() const { return static_cast<int>(targets_.size()); }

  /// glTF 2.0, appendix C.
  Eigen::MatrixXd PointsAt(double seconds) const {
    Eigen::MatrixXd points = base_;
    if (times_.rows() == 0) return points;
    Eigen::Index i = 0;
    while (i + 2 < times_.rows() && times_(i + 1, 0) <= seconds) ++i;
    const double share =
        std::clamp((seconds - times_(i, 0)) / (times_(i + 1, 0) - times_(i, 0)), 0.0, 1.0);
    for (int k = 0; k < target_count(); ++k)
      points += ((1 - share) * weights_(i, k) + share * weights_(i + 1, k)) * targets_[k];
    return points;
  }

 private:
  Eigen::MatrixXd Read(const nlohmann::json& accessor, int columns) const {
    const auto& view =
        json_["bufferViews"][json_["accessors"][accessor.get<int>()]["bufferView"].get<int>()];
    std::vector<float> numbers(view["byteLength"].get<std::size_t>() / 4);
    std::memcpy(numbers.data(), binary_.data() + view.value("byteOffset", 0), 4 * numbers.size());
    using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<Rows>(numbers.data(), std::ssize(numbers) / columns, columns).cast<double>();
  }

  nlohmann::json json_;
  std::string binary_;
  Eigen::MatrixXd base_, times_, weights_;
  std::vector<Eigen::MatrixXd> targets_;
};

FormatFiles Made(const Scene& scene, const FewTargetsOptions& options = {}) {
  return MakeFewTargetsGlb(scene, {}, options, nullptr);
}

/// Distance over the diagonal between what plays at a time and the points, with y up.
double DistanceAt(const Player& player, const Scene& scene, double seconds,
                  const PointsX3& wanted) {
  const PointsX3 points = player.PointsAt(seconds);
  return std::sqrt((points - WithYUp(wanted, scene.z_up)).rowwise().squaredNorm().maxCoeff()) /
         SceneDiagonal(scene);
}

/// The largest distance at all frames that show, or `share` of the way to the next.
double WorstDistance(const Player& player, const Scene& scene, double share) {
  const std::vector<int> shown = ShownFrames(scene);
  double worst = 0;
  for (std::size_t i = 0; i + 1 < shown.size(); ++i) {
    const auto& points = scene.split.points;
    const PointsX3 wanted = (1 - share) * points[shown[i]] + share * points[shown[i + 1]];
    const double seconds = (static_cast<double>(i) + share) / scene.playback.fps;
    worst = std::max(worst, DistanceAt(player, scene, seconds, wanted));
  }
  return worst;
}

TEST(MakeFewTargetsGlb, LimbThatBendsBy120DegreesNeedsFourTargets) {
  const Scene scene = SceneOf(BendingLimb(24));
  const FormatFiles made = Made(scene);
  const Player player(made.files[0].bytes);
  EXPECT_EQ(made.files[0].path, "character_few.glb");
  EXPECT_LE(player.target_count(), 4);
  EXPECT_EQ(made.measured.at("morph_targets"), player.target_count());
  EXPECT_LE(made.error_over_diagonal, 1e-5);
  EXPECT_NEAR(WorstDistance(player, scene, 0), made.error_over_diagonal, 1e-7);
}

TEST(MakeFewTargetsGlb, ErrorBetweenFramesIsNotLargerThanAtThem) {
  const Scene scene = SceneOf(WrithingSphere(20));
  const FormatFiles made = Made(scene);
  const Player player(made.files[0].bytes);
  for (const double share : {0.25, 0.5, 0.75})
    EXPECT_LE(WorstDistance(player, scene, share), made.error_over_diagonal + 1e-6);
}

TEST(MakeFewTargetsGlb, AtMostEightTargetsAndTheErrorThatIsClaimed) {
  const Scene scene = SceneOf(WrithingSphere(20));
  const FormatFiles made = Made(scene);
  const Player player(made.files[0].bytes);
  EXPECT_EQ(player.target_count(), 8);
  EXPECT_NEAR(WorstDistance(player, scene, 0), made.error_over_diagonal, 1e-7);
  EXPECT_GT(made.error_over_diagonal, made.measured.at("error_bound")) << "this motion is too rich";
  EXPECT_LT(made.error_over_diagonal, 0.7 * made.measured.at("picture_targets_error_over_diagonal"))
      << "eight of the pictures as targets must be clearly worse";
  EXPECT_LT(made.measured.at("rms_over_diagonal"), made.error_over_diagonal);
}

TEST(MakeFewTargetsGlb, WorstFrameAndVolumeAreThoseOfTheFile) {
  const Scene scene = SceneOf(WrithingSphere(20));
  const FormatFiles made = Made(scene);
  const Player player(made.files[0].bytes);
  double volume = 0, worst = 0;
  int worst_frame = -1;
  for (int i = 0; i < scene.frame_count(); ++i) {
    const double seconds = i / scene.playback.fps;
    const double distance = DistanceAt(player, scene, seconds, scene.split.points[i]);
    if (distance > worst) worst = distance, worst_frame = i;
    const double is = SignedVolume(player.PointsAt(seconds), scene.split.faces);
    const double should_be = SignedVolume(scene.split.points[i], scene.split.faces);
    volume = std::max(volume, std::abs(is - should_be));
  }
  volume /= SignedVolume(scene.frames[0].points, scene.frames[0].faces);
  EXPECT_EQ(made.measured.at("worst_frame"), worst_frame);
  EXPECT_NEAR(made.measured.at("volume_error"), volume, 1e-5);
}

TEST(MakeFewTargetsGlb, FewerTargetsThanThePicturesNeedAreUsedWhenAllowed) {
  const Scene scene = SceneOf(BendingLimb(24));
  double last = 1;
  for (const int targets : {1, 2, 3}) {
    const FormatFiles made = Made(scene, {targets, 1e-5});
    EXPECT_EQ(made.measured.at("morph_targets"), targets);
    EXPECT_LT(made.error_over_diagonal, last / 4);
    last = made.error_over_diagonal;
  }
}

TEST(MakeFewTargetsGlb, StretchingIsOneTarget) {
  std::vector<Mesh> frames(6, MakeBox(1, 2, 3));
  for (int i = 0; i < 6; ++i) frames[i].points.col(2) *= 1 + 0.3 * i * i;
  const FormatFiles made = Made(SceneOf(frames));
  EXPECT_EQ(made.measured.at("morph_targets"), 1);
  EXPECT_LT(made.error_over_diagonal, 1e-6);
}

TEST(MakeFewTargetsGlb, NoMoreTargetsThanPicturesBeyondTheFirst) {
  auto frames = WrithingSphere(4);
  const FormatFiles made = Made(SceneOf(frames));
  EXPECT_EQ(made.measured.at("morph_targets"), 3);
  EXPECT_LT(made.error_over_diagonal, 1e-6) << "three targets are enough for any four pictures";
}

TEST(MakeFewTargetsGlb, WeightsStayWithinSlidersAndTheBaseIsTheFirstFrame) {
  const Scene scene = SceneOf(BendingLimb(24));
  const FormatFiles made = Made(scene);
  const Player player(made.files[0].bytes);
  EXPECT_EQ(made.measured.at("base_is_first_frame"), 1);
  EXPECT_GE(player.weights().minCoeff(), 0);
  EXPECT_LE(player.weights().maxCoeff(), 1);
  for (int k = 0; k < player.target_count(); ++k)
    EXPECT_EQ(player.weights().col(k).maxCoeff(), 1) << "each slider is used to its end";
  EXPECT_EQ(player.json()["meshes"][0]["weights"], nlohmann::json::array({0.0, 0.0, 0.0, 0.0}));
  const PointsX3 base = player.base();
  EXPECT_LT((base - WithYUp(scene.split.points[0], true)).cwiseAbs().maxCoeff(),
            1e-5 * SceneDiagonal(scene));
}

TEST(MakeFewTargetsGlb, MotionAroundACircleKeepsWithinSlidersToo) {
  const Scene scene = SceneOf(CirclingBox(49));
  const FormatFiles made = Made(scene);
  const Player player(made.files[0].bytes);
  EXPECT_EQ(player.target_count(), 2);
  EXPECT_GE(player.weights().minCoeff(), 0);
  EXPECT_LE(player.weights().maxCoeff(), 1);
  EXPECT_LT(made.error_over_diagonal, 1e-6);
  EXPECT_EQ(made.measured.at("base_is_first_frame"), 0) << "the circle goes on both sides of it";
  const auto& at_rest = player.json()["meshes"][0]["weights"];
  PointsX3 points = player.base();
  for (int k = 0; k < 2; ++k) points += at_rest[k].get<double>() * player.target(k);
  EXPECT_LT((points - WithYUp(scene.split.points[0], true)).cwiseAbs().maxCoeff(), 1e-5)
      << "viewers that do not play must show the first frame";
}

TEST(MakeFewTargetsGlb, HoldsStandStillAndStepsAreSteps) {
  // A hold, a blend, two pictures on twos, a step back to the first picture.
  const std::vector<Mesh> limbs = BendingLimb(12);
  const std::vector<int> order{0, 0, 0, 4, 8, 11, 11, 6, 6, 0};
  std::vector<Mesh> frames;
  for (const int i : order) frames.push_back(limbs[i]);
  const std::vector<char> stands{1, 1, 0, 0, 0, 1, 1, 1, 1, 0};
  const Scene scene = SceneOf(frames, stands);
  const FormatFiles made = Made(scene, {8, 1e-6});
  const Player player(made.files[0].bytes);
  for (int i = 0; i < 9; ++i) {
    for (const double share : {0.0, 0.4, 0.9, 0.998}) {
      const double between = stands[i] ? 0 : share;
      const PointsX3 wanted =
          (1 - between) * scene.split.points[i] + between * scene.split.points[i + 1];
      EXPECT_LT(DistanceAt(player, scene, (i + share) / 10, wanted), 3e-6)
          << "frame " << i << " + " << share;
    }
  }
}

TEST(MakeFewTargetsGlb, SinglePictureHasNeitherTargetsNorAnimation) {
  const FormatFiles made = Made(SceneOf({MakeIcosphere(2)}));
  const Player player(made.files[0].bytes);
  EXPECT_EQ(player.target_count(), 0);
  EXPECT_FALSE(player.json().contains("animations"));
  EXPECT_FALSE(player.json()["meshes"][0].contains("weights"));
  EXPECT_LT(made.error_over_diagonal, 1e-7);
}

TEST(MakeFewTargetsGlb, BadOptionsThrowUsageErrorsThatNameThem) {
  const Scene scene = SceneOf(BendingLimb(3));
  EXPECT_THROW(Made(scene, {0, 1e-5}), UsageError);
  EXPECT_THROW(Made(scene, {8, 0}), UsageError);
  EXPECT_THROW(Made(scene, {8, NAN}), UsageError);
  EXPECT_EQ((FewTargetsOptions{300, -1}.Problems().size()), 2u);
  EXPECT_TRUE(FewTargetsOptions{}.Problems().empty());
}

TEST(MakeFewTargetsGlb, TextureWithoutCoordinatesThrowsInputError) {
  const GlbTextures textures{{{"bytes", "image/png", "clay"}}, {"rest"}, {}};
  EXPECT_THROW(MakeFewTargetsGlb(SceneOf(BendingLimb(3)), textures, {}, nullptr), InputError);
}

TEST(MakeFewTargetsGlb, SameBytesForAnyThreadCount) {
  const Scene scene = SceneOf(WrithingSphere(14));
  SetThreadCount(1);
  const std::string one = Made(scene).files[0].bytes;
  SetThreadCount(4);
  const std::string four = Made(scene).files[0].bytes;
  SetThreadCount(0);
  EXPECT_EQ(one, four);
}

class FewTargetsFile : public ::testing::Test {
 protected:
  /// @return the scene's measured file
  FormatFiles Write(const Scene& scene) {
    const FormatFiles made =
        MakeFewTargetsGlb(scene, {scene.textures, scene.poses, {}}, {}, nullptr);
    WriteFile(Path(), made.files[0].bytes);
    WriteTruth(scene, folder_.path() / "truth");
    return made;
  }
  std::string Path() const { return (folder_.path() / "character_few.glb").string(); }
  std::string Truth() const { return (folder_.path() / "truth").string(); }
  TestingFolder folder_;
};

/// Bends on ones, then steps on twos, then bends back; with held ends.
Scene MixedScene(bool with_uvs) {
  TestSceneOptions options;
  options.bends = {0, 2, 5, 9, 9, 6, 6, 4, 1};
  options.stands = {0, 0, 0, 1, 1, 1, 1, 0, 0};
  options.playback = {25, 2, "none"};
  options.with_uvs = with_uvs;
  return TestScene(options);
}

TEST_F(FewTargetsFile, PassesTheKhronosValidatorWithoutErrorsAndWarnings) {
  if (!HasReader("node") || !fs::exists(SourceFolder() + "/node_modules/gltf-validator"))
    GTEST_SKIP() << "node or node_modules/gltf-validator is missing: run ./dev setup";
  for (const Scene& scene :
       {MixedScene(true), SceneOf(CirclingBox(49)), SceneOf({MakeBox(1, 2, 3)})}) {
    Write(scene);
    const ReaderResult read =
        RunReader({"node", SourceFolder() + "/tests/validate_gltf.mjs", Path()});
    EXPECT_EQ(read.exit_code, 0) << read.output;
    EXPECT_NE(read.output.find("0 errors, 0 warnings"), std::string::npos) << read.output;
  }
}

TEST_F(FewTargetsFile, PlaysInThreeJsAsClaimed) {
  if (!HasReader("node") || !fs::exists(SourceFolder() + "/node_modules/three"))
    GTEST_SKIP() << "node or node_modules/three is missing: run ./dev setup";
  for (const Scene& scene : {MixedScene(false), SceneOf(WrithingSphere(14))}) {
    const FormatFiles made = Write(scene);
    const ReaderResult read =
        RunReader({"node", SourceFolder() + "/export/gltf/testing/play_few.mjs", Path(), Truth()});
    ASSERT_EQ(read.exit_code, 0) << read.output;
    EXPECT_EQ(FigureOf(read.output, "targets"), made.measured.at("morph_targets"));
    EXPECT_NEAR(FigureOf(read.output, "worst"), made.error_over_diagonal, 5e-7);
    EXPECT_LE(FigureOf(read.output, "between"), made.error_over_diagonal + 2e-6);
    EXPECT_LE(FigureOf(read.output, "at_rest"), made.error_over_diagonal + 1e-6);
    EXPECT_NEAR(FigureOf(read.output, "normal_deg"), made.measured.at("normal_rms_deg"),
                0.1 + 0.2 * made.measured.at("normal_rms_deg"))
        << "here each shown frame counts, there each picture";
    EXPECT_GE(FigureOf(read.output, "least"), 0);
    EXPECT_LE(FigureOf(read.output, "most"), 1);
  }
}

TEST_F(FewTargetsFile, PlaysInBlenderAsClaimed) {
  if (!HasReader("blender")) GTEST_SKIP() << "blender is missing: run ./dev setup";
  const FormatFiles made = Write(MixedScene(true));
  const ReaderResult read =
      RunReader({"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                 SourceFolder() + "/export/gltf/testing/check_few.py", "--", Path(), Truth()});
  ASSERT_EQ(read.exit_code, 0) << read.output;
  EXPECT_EQ(FigureOf(read.output, "targets"), made.measured.at("morph_targets"));
  EXPECT_EQ(FigureOf(read.output, "sliders"), made.measured.at("morph_targets"))
      << "Blender keeps its sliders from 0 to 1";
  EXPECT_NEAR(FigureOf(read.output, "worst"), made.error_over_diagonal, 1e-6);
  EXPECT_LE(FigureOf(read.output, "between"), made.error_over_diagonal + 2e-6);
}

}  // namespace keypose::exporting::few_targets_test
