#include "synth/rooms/room_photographer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "synth/rooms/testing/small_room.h"

namespace keypose::synth::room_photographer_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

}  // namespace keypose::synth::room_photographer_test
