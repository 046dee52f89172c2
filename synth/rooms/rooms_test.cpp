#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/testing/folder.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/photographs/truth_files.h"
#include "synth/rooms/room_command.h"
#include "synth/rooms/room_photographer.h"

namespace keypose::synth::rooms_test {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A small room in about a second.
RoomOptions Small(const std::string& kind, std::uint64_t seed = 3, int photographs = 6) {
  RoomOptions options;
  options.kind = kind, options.seed = seed, options.photographs = photographs;
  options.width = 240, options.height = 160;
  options.second = "none", options.hands = 0;
  options.detail = 0.06, options.spacing_m = 0.007;
  return options;
}

RoomPhotographer Photographed(const RoomOptions& options) {
  return RoomPhotographer(PlanRoom(options));
}

/// Pixels of the true mesh in the true camera that the mask has too, over those that either has.
double Overlap(const RoomPhotographer& photographer, int i, const Image8& mask) {
  const Mesh& surface = photographer.set().figure().surface;
  const Raster raster = Rasterize(surface, RayScene(surface.points, surface.faces),
                                  photographer.room_views()[i].OfFigure());
  int both = 0, either = 0;
  for (std::size_t p = 0; p < mask.data.size(); ++p) {
    const bool seen = raster.face.data[p] >= 0, masked = mask.data[p] > 127;
    both += seen && masked, either += seen || masked;
  }
  EXPECT_GT(either, 500);
  return static_cast<double>(both) / either;
}

TEST(Rooms, MasksAreTheTrueMeshInTheTrueCameras) {
  for (const std::string kind : {"walk", "both", "one-side"}) {
    const RoomPhotographer photographer = Photographed(Small(kind));
    for (const int i : {0, 3, 5})
      // "Half of the pixel" and "its middle" differ at the edge, which has about 300 pixels here.
      EXPECT_GT(Overlap(photographer, i, photographer.Take(i).mask), 0.96) << kind << " " << i;
  }
}

/// Whether the pixel and those that the lens blurs into it show only walls and what hangs there.
bool StillAround(const Image8& parts, int x, int y) {
  for (int j = y - 2; j <= y + 2; ++j)
    for (int i = x - 2; i <= x + 2; ++i)
      if (i < 0 || j < 0 || i >= parts.width || j >= parts.height || *parts.at(i, j) != 0)
        return false;
  return true;
}

TEST(Rooms, StillWallIsTheSameInAllPhotographsFromATripod) {
  RoomOptions options = Small("mat");
  options.noise = 0;
  const RoomPhotographer photographer = Photographed(options);
  const RoomPhotograph first = photographer.Take(0), later = photographer.Take(2);
  ASSERT_EQ(photographer.room_views()[0].tripod, photographer.room_views()[2].tripod);
  int compared = 0, moved = 0;
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      if (!StillAround(first.parts, x, y) || !StillAround(later.parts, x, y)) {
        moved += !std::equal(first.image.at(x, y), first.image.at(x, y) + 3, later.image.at(x, y));
        continue;
      }
      ++compared;
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(first.image.at(x, y)[c], later.image.at(x, y)[c]) << x << " " << y;
    }
  EXPECT_GT(compared, 3000);
  EXPECT_GT(moved, 1000);  // figure and mat
}

TEST(Rooms, SensorsNoiseIsAllThatDiffersOnAStillWall) {
  const RoomPhotographer photographer = Photographed(Small("mat"));
  const RoomPhotograph first = photographer.Take(0), later = photographer.Take(2);
  int compared = 0, equal = 0;
  double difference = 0;
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 240; ++x)
      if (StillAround(first.parts, x, y) && StillAround(later.parts, x, y)) {
        const int gap = first.image.at(x, y)[1] - later.image.at(x, y)[1];
        ++compared, equal += gap == 0, difference += gap;
      }
  EXPECT_LT(equal, 0.5 * compared);  // two draws of the noise
  EXPECT_LT(std::abs(difference / compared), 0.2);
}

TEST(Rooms, InTheHandTheWallMovesToo) {
  const RoomPhotographer photographer = Photographed(Small("mat-hand"));
  for (int i = 1; i < 6; ++i) {
    const Rigid3 still = Compose(photographer.room_views()[i].view.camera_from_world,
                                 photographer.room_views()[0].view.camera_from_world.Inverse());
    EXPECT_GT(Eigen::AngleAxisd(still.rotation).angle(), 0.005);
    EXPECT_LT(Eigen::AngleAxisd(still.rotation).angle(), 0.5);
  }
}

/// The mat's sheet is where the true cameras have it, also in pictures held upright.
TEST(Rooms, MatIsWhereTheTrueCamerasProjectIt) {
  RoomOptions options = Small("both", 3, 10);
  const RoomPhotographer photographer = Photographed(options);
  const PointsX3 mat = photographer.set().close.AsMesh().points;
  const double top = mat.col(2).maxCoeff();
  for (const int i : {0, 4, 9}) {
    const View view = photographer.room_views()[i].OfFigure();
    const Image8 parts = photographer.Take(i).parts;
    int both = 0, either = 0;
    for (int y = 0; y < parts.height; ++y)
      for (int x = 0; x < parts.width; ++x) {
        if (*parts.at(x, y) >= 180) continue;  // the figure hides it
        const Vector3d eye = view.Center(), ray = view.camera_from_world.rotation.conjugate() *
                                                  view.camera.Unproject({x + 0.5, y + 0.5});
        const Vector3d p = eye + (top - eye.z()) / ray.z() * ray;
        const bool on_disc = p.head<2>().norm() < mat.leftCols<2>().rowwise().norm().maxCoeff();
        const bool on_sheet =
            std::abs(p.x()) < mat.col(0).maxCoeff() && std::abs(p.y()) < mat.col(1).maxCoeff();
        const bool disc = photographer.plan().support == "disc";
        const bool here = ray.z() < 0 && (disc ? on_disc : on_sheet), seen = *parts.at(x, y) == 140;
        both += here && seen, either += here || seen;
      }
    EXPECT_GT(either, 1000) << i;
    EXPECT_GT(both, (photographer.plan().support == "disc" ? 0.85 : 0.96) * either) << i;
  }
}

TEST(Rooms, SecondThingTouchesOrStandsApartAsAsked) {
  for (const std::string second : {"touching", "apart"}) {
    RoomOptions options = Small("mat", second == "apart" ? 5 : 4);
    options.second = second;
    const RoomPhotographer photographer = Photographed(options);
    const RoomSet& set = photographer.set();
    double gap = std::numeric_limits<double>::infinity();
    const auto measure = [&](const PointsX3& points) {
      for (Eigen::Index i = 0; i < points.rows(); ++i)
        gap = std::min(gap,
                       std::sqrt(set.figure().scene.ClosestPoint(points.row(i)).squared_distance));
    };
    for (std::size_t i = 1; i < set.clay.size(); ++i) measure(set.clay[i]->clay.surface.points);
    if (set.clay.size() == 1) measure(set.close.Standing().points);
    int pixels = 0;
    for (const std::uint8_t part : photographer.Take(0).parts.data) pixels += part == 180;
    EXPECT_GT(pixels, 50) << second;
    EXPECT_EQ(set.second_gap_m > 0, second == "apart");
    EXPECT_GT(gap, second == "apart" ? 0.008 : 0) << second;
  }
}

TEST(Rooms, HandsHideTheFigureInSoManyPhotographs) {
  RoomOptions options = Small("mat");
  options.hands = 2;
  const RoomPhotographer photographer = Photographed(options);
  int hands = 0;
  for (int i = 0; i < 6; ++i) hands += photographer.HasHand(i);
  ASSERT_EQ(hands, 2);
  for (int i = 0; i < 6; ++i) {
    const RoomPhotograph photograph = photographer.Take(i);
    const auto& parts = photograph.parts.data;
    const auto of_hand = std::count(parts.begin(), parts.end(), std::uint8_t{60});
    EXPECT_EQ(of_hand > 200, photographer.HasHand(i)) << i;
  }
}

TEST(Rooms, CarvingsAreHalfInsideWhatTheyAreCarvedFrom) {
  for (const std::string kind : {"trunk", "relief"}) {
    RoomOptions options = Small(kind);
    const RoomPhotographer photographer = Photographed(options);
    EXPECT_FALSE(photographer.plan().free_standing());
    const double share = Overlap(photographer, 2, photographer.Take(2).mask);
    EXPECT_GT(share, 0.4) << kind;
    EXPECT_LT(share, 0.97) << kind;
  }
}

TEST(Rooms, SameBitsAtOneAndManyThreads) {
  SetThreadCount(1);
  const RoomPhotograph one = Photographed(Small("walk")).Take(2);
  SetThreadCount(4);
  const RoomPhotograph many = Photographed(Small("walk")).Take(2);
  SetThreadCount(0);
  EXPECT_EQ(one.image.data, many.image.data);
  EXPECT_EQ(one.mask.data, many.mask.data);
  EXPECT_EQ(one.parts.data, many.parts.data);
}

TEST(Rooms, TurnedCameraSeesThePictureTurnedClockwise) {
  Camera camera;
  camera.width = 300, camera.height = 200;
  camera.fx = 310, camera.fy = 320, camera.cx = 147, camera.cy = 104;
  camera.k1 = -0.1, camera.k2 = 0.03, camera.p1 = 0.004, camera.p2 = -0.003;
  const Camera turned = TurnedClockwise(camera);
  EXPECT_EQ(turned.width, 200);
  // The camera has turned counter-clockwise about its axis: right is up.
  const Vector3d x(0.3, -0.2, 1), in_turned(-x.y(), x.x(), x.z());
  const Vector2d before = camera.Project(x), after = turned.Project(in_turned);
  EXPECT_NEAR(after.x(), camera.height - before.y(), 1e-9);
  EXPECT_NEAR(after.y(), before.x(), 1e-9);
}

TEST(RoomPlans, TwentyFourSeedsHoldAllKindsInBalance) {
  std::map<std::string, int> kinds, seconds;
  int hands = 0, without_exif = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    RoomOptions options;
    options.seed = seed;
    const RoomPlan plan = PlanRoom(options);
    EXPECT_TRUE(plan.free_standing());
    ++kinds[NameOf(plan.kind)], ++seconds[plan.second];
    hands += plan.hands > 0, without_exif += !plan.exif;
  }
  EXPECT_EQ(kinds, (std::map<std::string, int>{
                       {"walk", 6}, {"mat", 6}, {"mat-hand", 4}, {"both", 5}, {"one-side", 3}}));
  EXPECT_EQ(seconds["touching"], 6);
  EXPECT_GE(seconds["apart"], 3);
  EXPECT_GE(hands, 4);
  EXPECT_EQ(without_exif, 4);
}

TEST(RoomPlans, BadOptionsThrowUsageError) {
  const auto refuse = [](auto change) {
    RoomOptions options = Small("walk");
    change(options);
    EXPECT_THROW(PlanRoom(options), UsageError);
  };
  refuse([](RoomOptions& o) { o.kind = "garden"; });
  refuse([](RoomOptions& o) { o.photographs = 2; });
  refuse([](RoomOptions& o) { o.width = 3; });
  refuse([](RoomOptions& o) { o.second = "three"; });
  refuse([](RoomOptions& o) { o.exif = "maybe"; });
  refuse([](RoomOptions& o) { o.lenses = 3; });
  refuse([](RoomOptions& o) { o.hands = 7; });
  refuse([](RoomOptions& o) { o.detail = 0; });
  int width = 0, height = 0;
  ReadSize("640x480", &width, &height);
  EXPECT_EQ(width, 640);
  EXPECT_EQ(height, 480);
  for (const char* text : {"640", "640x", "x480", "640x480x3", "ax9"})
    EXPECT_THROW(ReadSize(text, &width, &height), UsageError) << text;
}

TEST(RoomCommand, WritesPhotographsAndTheirTruthBesideThem) {
  const TestingFolder folder;
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("both", 4, 10);
  command.room.lenses = 2, command.room.exif = "yes";
  RunRoom(command, nullptr);
  const fs::path truth = folder.path() / "truth/figure", photos = folder.path() / "photos/figure";
  const auto json = nlohmann::json::parse(ReadFile(truth / "room.json"));
  EXPECT_EQ(json.at("kind"), "both");
  ASSERT_EQ(json.at("photographs").size(), 10u);
  const auto &ring = json["photographs"][0], &close = json["photographs"][9];
  EXPECT_EQ(ring.at("part"), "ring");
  EXPECT_EQ(ring.at("tripod"), 0);
  EXPECT_TRUE(close.at("tripod").is_null());
  EXPECT_NE(ring.at("portrait"), close.at("portrait"));
  EXPECT_NEAR(ReadImageInfo(photos / "IMG_0010.jpg").focal_35mm.value_or(0) /
                  json["lenses"][1]["focal_35mm"].get<double>(),
              1, 0.02);
  // A pixel inside the figure; both models hold the same camera in two frames.
  const Image8 mask = ReadImage(truth / "masks/IMG_0010.jpg.png", 1);
  EXPECT_EQ(*mask.at(close["inside"][0], close["inside"][1]), 255);
  const Scene of_figure = ReadColmapModel(truth / "cameras"),
              of_room = ReadColmapModel(truth / "cameras_of_room");
  const double turn = close["turn_deg"].get<double>() * kDegree;
  const Vector3d turned = Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * of_figure.views[9].Center();
  EXPECT_LT((turned - of_room.views[9].Center()).norm(), 1e-9);
  EXPECT_GT(ReadTruth(truth).cameras.points.size(), 100u);
}

TEST(RoomCommand, ALineLiesOnWhatTouchesTheFigure) {
  const TestingFolder folder;
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("walk", 5, 6);
  command.room.second = "touching";
  RunRoom(command, nullptr);
  const fs::path truth = folder.path() / "truth/figure";
  const auto json = nlohmann::json::parse(ReadFile(truth / "room.json"));
  int lines = 0;
  for (const auto& photograph : json.at("photographs")) {
    const auto& beside = photograph.at("beside");
    if (beside[0] < 0) continue;
    ++lines;
    const Image8 parts =
        ReadImage(truth / "parts" / (photograph["name"].get<std::string>() + ".png"), 1);
    EXPECT_EQ(beside[1], beside[3]);
    for (int x = beside[0]; x <= beside[2]; ++x)
      ASSERT_EQ(*parts.at(x, beside[1].get<int>()), static_cast<int>(Part::kThing));
  }
  EXPECT_GE(lines, 4);
}

TEST(RoomCommand, WithoutExifNoneIsWritten) {
  const TestingFolder folder;
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("mat", 4, 4);
  command.room.exif = "no";
  RunRoom(command, nullptr);
  const ImageInfo info = ReadImageInfo(folder.path() / "photos/figure/IMG_0001.jpg");
  EXPECT_FALSE(info.focal_35mm.has_value());
  EXPECT_FALSE(info.focal_mm.has_value());
}

TEST(RoomCommand, PhotographsOfSomebodyElseAreNotWrittenOver) {
  const TestingFolder folder;
  fs::create_directories(folder.path() / "photos/figure");
  WriteFile(folder.path() / "photos/figure/IMG_0001.jpg", "a real one");
  RoomCommand command;
  command.output = folder.path();
  command.room = Small("mat", 4, 4);
  EXPECT_THROW(RunRoom(command, nullptr), UsageError);
}

}  // namespace keypose::synth::rooms_test
