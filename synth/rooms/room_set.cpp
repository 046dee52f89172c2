#include "synth/rooms/room_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/values/angles.h"
#include "synth/rooms/furnishing.h"
#include "synth/rooms/printed.h"
#include "synth/rooms/surfaces.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTableHalfWidth = 0.3;  // [m] of the shadows' grid around the figure
constexpr double kFloor = -0.74;         // [m] below the table
constexpr double kTouch = 2e-4;          // [m] between things that touch

Rigid3 At(const Vector3d& place, double turn_rad = 0) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ())), place};
}

/// The clay in another material: one colour with grain, nothing painted.
void Carve(World& world, const Vector3d& color) {
  world.clay.spots.clear();
  for (Lump& lump : world.clay.lumps) {
    lump.color = color;
    lump.crisp = false;
  }
  world.clay.ridge_height = 0;
}

World WorldOf(const RoomPlan& plan) {
  WorldOptions options;
  options.character = plan.character;
  options.seed = plan.figure_seed;
  options.spacing_m = plan.spacing_m;
  options.texture = plan.texture;
  if (plan.pose == "limbs") options.pose_seed = plan.figure_seed;
  World world = MakeWorld(options);
  if (plan.support == "trunk") Carve(world, {0.22, 0.13, 0.07});
  if (plan.support == "wall") Carve(world, {0.36, 0.33, 0.28});
  return world;
}

double Reach(const PointsX3& points) { return points.leftCols<2>().rowwise().norm().maxCoeff(); }

/// Makes `thing` slide along the ground towards the figure, from a direction, until they touch.
/// @param points  of the thing, its foot at the origin
/// @return where its foot is then
Vector3d SlideToTouch(const RayScene& figure, const PointsX3& points, double azimuth, double from) {
  const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
  double distance = from;
  for (int step = 0; step < 60; ++step) {
    double gap = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Vector3d p = Vector3d(points.row(i)) + distance * out;
      gap = std::min(gap, std::sqrt(figure.ClosestPoint(p, gap).squared_distance));
    }
    if (gap < kTouch || distance <= 0) break;
    distance -= gap;
  }
  return distance * out;
}

class Furnisher {
 public:
  explicit Furnisher(const RoomPlan& plan)
      : plan_(plan), streams_(plan.seed * 40503 + 11, plan.detail), random_(streams_.Next()) {
    set_.world = WorldOf(plan);
  }

  RoomSet Furnished() && {
    AddFigure();
    if (plan_.kind == RoomKind::kTrunk)
      Wood();
    else if (plan_.kind == RoomKind::kRelief)
      ReliefWall();
    else
      Table();
    if (plan_.second != "none") AddSecond();
    if (!plan_.turns() && plan_.free_standing()) ScatterThings();
    Light();
    return std::move(set_);
  }

 private:
  void AddFigure() {
    PointsX3 points = set_.world.PoseNamed(plan_.pose)(set_.world.rest.points);
    if (plan_.kind == RoomKind::kRelief) {  // pressed flat, half of it in the wall
      points.col(1) = 0.45 * (points.col(1).array() - 0.01);
    }
    if (plan_.kind == RoomKind::kTrunk) points.col(1) *= 0.8;
    set_.clay.push_back(std::make_unique<ClayThing>(set_.world, points, Part::kFigure));
  }

  /// A table in a room, and what the figure stands on.
  void Table() {
    const bool near_wall = plan_.kind != RoomKind::kWalk;
    Support();
    const double wide = random_.Uniform(1.1, 1.5), deep = random_.Uniform(0.8, 1.0);
    const double back = near_wall ? random_.Uniform(0.34, 0.5) : deep / 2;
    AddTable(set_.room, {random_.Uniform(-0.1, 0.1), back - deep / 2, set_.table_z}, wide, deep,
             streams_);
    const double behind = near_wall ? back + 0.03 : random_.Uniform(1.5, 2.1);
    const Vector3d low(-random_.Uniform(1.5, 2.2), -random_.Uniform(1.6, 2.2), kFloor),
        high(random_.Uniform(1.5, 2.2), behind, random_.Uniform(1.6, 1.9));
    AddWalls(set_.room, low, high, streams_);
    if (near_wall)
      ShelfOnWall(behind);
    else
      ShelvesAround(low, high);
  }

  /// Shelves behind the table, hung on the wall or standing on it.
  void ShelfOnWall(double wall) {
    const double deep = 0.16, foot = random_.Uniform() < 0.5 ? set_.table_z : 0.16;
    if (random_.Uniform() < 0.75)
      AddShelf(set_.room, At({-0.75, wall - deep - 0.005, foot}), {1.5, deep, 1.1}, streams_);
    else
      for (int i = 0; i < 5; ++i) {  // pictures that lean against the wall
        const double w = random_.Uniform(0.18, 0.34), h = w * random_.Uniform(0.8, 1.4);
        Print print =
            i % 2 ? PaintingPrint(w, h, streams_.Next()) : PosterPrint(w, h, streams_.Next());
        set_.room.Add({{-0.8 + 0.33 * i, wall - 0.012, set_.table_z + h},
                       {w, 0, 0},
                       {0, -0.03, -h},
                       set_.room.AddPrint(std::move(print)),
                       Part::kRoom,
                       0.05,
                       false});
      }
  }

  void ShelvesAround(const Vector3d& low, const Vector3d& high) {
    const double tall = 1.9, deep = 0.26;
    AddShelf(set_.room, At({low.x() + 0.2, high.y() - deep - 0.01, kFloor}),
             {random_.Uniform(1.2, 2.0), deep, tall}, streams_);
    AddShelf(set_.room, At({high.x() - 0.3, low.y() + deep + 0.01, kFloor}, kPi),
             {random_.Uniform(1.0, 1.8), deep, tall}, streams_);
    if (random_.Uniform() < 0.7)
      AddShelf(set_.room, At({low.x() + deep + 0.01, low.y() + 0.9, kFloor}, kPi / 2),
               {1.1, deep, tall * 0.6}, streams_);
  }

  void Support() {
    Furniture& close = set_.close;
    if (plan_.support == "book") {
      const double thick = random_.Uniform(0.018, 0.04);
      set_.table_z = -thick;
      AddLyingBook(close, {random_.Uniform(-0.015, 0.015), random_.Uniform(-0.015, 0.015), -thick},
                   {random_.Uniform(0.24, 0.3), random_.Uniform(0.2, 0.24), thick},
                   random_.Uniform(0, 6), Part::kSupport, streams_);
    }
    if (plan_.support == "mat") {
      const double side = random_.Uniform(0.27, 0.32);
      set_.table_z = -0.0012;
      const int print = close.AddPrint(MatPrint(side, streams_.Next()));
      close.Add({{-side / 2, side / 2, 0},
                 {side, 0, 0},
                 {0, -side, 0},
                 print,
                 Part::kSupport,
                 0.1,
                 true});
    }
    if (plan_.support == "disc") {
      const double radius = random_.Uniform(0.13, 0.155), thick = random_.Uniform(0.012, 0.03);
      set_.table_z = -thick;
      const int lid = close.AddPrint(MatPrint(2.06 * radius, streams_.Next())),
                rim = close.AddPrint(BoardsPrint(2 * kPi * radius, thick, 0.2, streams_.Next()));
      close.AddDrum(At({0, 0, -thick}), radius, thick, rim, lid, Part::kSupport, true);
    }
  }

  /// Another thing on what the figure stands on.
  void AddSecond() {
    const RayScene& figure = set_.figure().scene;
    const double first = random_.Uniform(0, 2 * kPi), turn = random_.Uniform(0, 6);
    const double clear = random_.Uniform(0.02, 0.045);
    const bool clay = random_.Uniform() < 0.3;
    const int kind = random_.Below(4);
    const PrintRandom look = streams_.Next();
    Furniture trial;
    PointsX3 points;
    World toy;
    if (clay) {
      toy = Toy(random_.Below(1000));
      points = toy.rest.points;
    } else {
      AddThing(trial, static_cast<ThingKind>(kind), At(Vector3d::Zero(), turn), Part::kThing, look);
      points = Densely(trial.AsMesh());
    }
    Vector3d foot = Nearest(figure, points, first);
    if (plan_.second == "apart") foot += clear * foot.normalized();
    set_.second_gap_m = plan_.second == "apart" ? clear : 0;
    taken_.push_back({foot.head<2>(), Reach(points)});
    set_.second = points.rowwise() + foot.transpose();
    if (clay)
      set_.clay.push_back(
          std::make_unique<ClayThing>(toy, points.rowwise() + foot.transpose(), Part::kThing));
    else
      AddThing(set_.close, static_cast<ThingKind>(kind), At(foot, turn), Part::kThing, look);
  }

  /// Of a few directions, where a thing that touches the figure stands nearest to its middle, so
  /// that it does not reach over a small support.
  Vector3d Nearest(const RayScene& figure, const PointsX3& points, double first) const {
    constexpr int kDirections = 5;
    const double from = Reach(set_.figure().surface.points) + 0.12;
    Vector3d nearest = Vector3d::Constant(from);
    for (int k = 0; k < kDirections; ++k) {
      const Vector3d foot = SlideToTouch(figure, points, first + 2 * kPi * k / kDirections, from);
      if (foot.norm() < nearest.norm()) nearest = foot;
    }
    return nearest;
  }

  /// A ball or an egg of clay.
  World Toy(int seed) const {
    World toy = set_.world;
    Random random(static_cast<std::uint64_t>(seed) * 31 + 7);
    const double radius = random.Uniform(0.018, 0.028), top = random.Uniform(0, 0.02);
    Lump lump;
    lump.a = Vector3d(0, 0, 0.92 * radius);
    lump.b = lump.a + Vector3d(0, 0, top);
    lump.ra = radius;
    lump.rb = 0.8 * radius;
    lump.color =
        Vector3d(random.Uniform(0.1, 0.7), random.Uniform(0.1, 0.5), random.Uniform(0.05, 0.5));
    toy.clay.lumps = {lump};
    toy.clay.spots.clear();
    toy.clay.seed += 77;
    Vector3d low, high;
    toy.clay.Bounds(&low, &high);
    toy.rest = Polygonize([&](const Vector3d& x) { return toy.clay.Distance(x); }, low, high,
                          plan_.spacing_m);
    toy.smooth = toy.rest.points;
    toy.landmarks.clear();
    return toy;
  }

  /// Points close together on a mesh of few faces.
  static PointsX3 Densely(const Mesh& mesh) {
    constexpr int kSteps = 12;
    PointsX3 points(mesh.faces.rows() * (kSteps + 1) * (kSteps + 2) / 2, 3);
    Eigen::Index row = 0;
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      for (int i = 0; i <= kSteps; ++i)
        for (int j = 0; i + j <= kSteps; ++j)
          points.row(row++) =
              (i * mesh.points.row(mesh.faces(f, 0)) + j * mesh.points.row(mesh.faces(f, 1)) +
               (kSteps - i - j) * mesh.points.row(mesh.faces(f, 2))) /
              kSteps;
    return points;
  }

  /// Books and small things on the table, apart from the figure and from each other.
  void ScatterThings() {
    taken_.push_back({Vector2d::Zero(), std::max(Reach(set_.figure().surface.points) + 0.05,
                                                 plan_.support == "book" ? 0.2 : 0.0)});
    for (int i = 0; i < 9; ++i) {
      const bool book = i < 3;
      const double radius = book ? 0.15 : 0.055, turn = random_.Uniform(0, 6);
      const PrintRandom look = streams_.Next();
      for (int attempt = 0; attempt < 20; ++attempt) {
        const Vector2d at(random_.Uniform(-0.46, 0.46),
                          random_.Uniform(plan_.kind == RoomKind::kWalk ? -0.34 : -0.05, 0.3));
        if (std::any_of(taken_.begin(), taken_.end(), [&](const auto& other) {
              return (other.first - at).norm() < other.second + radius + 0.01;
            }))
          continue;
        taken_.push_back({at, radius});
        const Vector3d foot(at.x(), at.y(), set_.table_z);
        if (book)
          AddLyingBook(set_.close, foot, {0.21, 0.15, random_.Uniform(0.008, 0.035)}, turn,
                       Part::kThing, streams_);
        else
          AddThing(set_.close, static_cast<ThingKind>(i % 4), At(foot, turn), Part::kThing, look);
        break;
      }
    }
  }

  /// Trees, fallen leaves; the carving's tree stands behind it.
  void Wood() {
    set_.table_z = -1.0;
    const double radius = random_.Uniform(0.15, 0.2);
    AddTree(set_.room, {0, 0.93 * radius}, radius, -1.0, 1.6, streams_.Next());
    const int leaves = set_.room.AddPrint(LeavesPrint(8, 8, streams_.Next()));
    set_.room.Add({{-4, 4, -1}, {8, 0, 0}, {0, -8, 0}, leaves, Part::kRoom, 0.1, false});
    for (int i = 0; i < 22; ++i) {
      const double angle = random_.Uniform(0, 2 * kPi), away = random_.Uniform(1.6, 3.2);
      AddTree(set_.room, {away * std::cos(angle), away * std::sin(angle)},
              random_.Uniform(0.06, 0.2), -1.0, 2.6, streams_.Next());
    }
    const int green = set_.room.AddPrint(FoliagePrint(8, 4, streams_.Next()));
    for (int side = 0; side < 4; ++side) {
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(side * kPi / 2, Vector3d::UnitZ()).toRotationMatrix();
      set_.room.Add({turn * Vector3d(-4, 4, 3),
                     turn * Vector3d(8, 0, 0),
                     {0, 0, -4},
                     green,
                     Part::kRoom,
                     0.5,
                     false});
    }
  }

  /// A wall of bricks or stones in the plane y = 0, from which the relief stands out.
  void ReliefWall() {
    set_.table_z = -1.0;
    const int stones = set_.room.AddPrint(MasonryPrint(3, 2.6, streams_.Next()));
    set_.room.Add({{-1.5, 0, 1.4}, {3, 0, 0}, {0, 0, -2.4}, stones, Part::kRoom, 0.03, false});
    const int floor = set_.room.AddPrint(MasonryPrint(4, 4, streams_.Next()));
    set_.room.Add({{-2, 0, -1}, {4, 0, 0}, {0, -4, 0}, floor, Part::kRoom, 0.1, false});
    const int far = set_.room.AddPrint(FoliagePrint(8, 4, streams_.Next()));
    set_.room.Add({{-4, 1.2, 3}, {8, 0, 0}, {0, 0, -4}, far, Part::kRoom, 0.5, false});
  }

  void Light() {
    set_.room.Finish();
    std::vector<const RayScene*> on_clay{&set_.figure().scene}, on_room{&set_.room.scene()};
    for (std::size_t i = 1; i < set_.clay.size(); ++i) on_clay.push_back(&set_.clay[i]->clay.scene);
    std::unique_ptr<RayScene> standing;
    if (!set_.close.empty()) {
      set_.close.Finish();
      on_clay.push_back(&set_.close.scene());
      const Mesh things = set_.close.Standing();
      if (things.faces.rows() > 0) {
        standing = std::make_unique<RayScene>(things.points, things.faces);
        // A disc looks the same however it is turned.
        if (!plan_.turns() || plan_.support == "disc") on_room.push_back(standing.get());
      }
      set_.close.Light(on_clay, plan_.light, plan_.turns(), false);
    }
    if (!plan_.free_standing()) on_room.push_back(&set_.figure().scene);
    set_.room.Light(on_room, plan_.light, false, true);
    const Mesh casts = Casting();
    set_.casts = std::make_unique<RayScene>(casts.points, casts.faces);
    set_.table = std::make_unique<TableLight>(*set_.casts, kTableHalfWidth);
    for (const std::unique_ptr<ClayThing>& thing : set_.clay)
      thing->light = std::make_unique<LightField>(thing->clay.surface, thing->clay.normals,
                                                  *set_.casts, plan_.light.elevation_rad);
  }

  /// Clay, and of a mat the things on it; those on a still table are in its own light.
  Mesh Casting() const {
    std::vector<Mesh> parts;
    for (const std::unique_ptr<ClayThing>& thing : set_.clay) parts.push_back(thing->clay.surface);
    if (plan_.turns() && plan_.second != "none" && !set_.close.empty())
      parts.push_back(set_.close.Standing());
    Mesh all;
    for (const Mesh& part : parts) {
      const Eigen::Index points = all.points.rows(), faces = all.faces.rows();
      all.points.conservativeResize(points + part.points.rows(), 3);
      all.points.bottomRows(part.points.rows()) = part.points;
      all.faces.conservativeResize(faces + part.faces.rows(), 3);
      all.faces.bottomRows(part.faces.rows()) = part.faces.array() + static_cast<int>(points);
    }
    return all;
  }

  RoomPlan plan_;
  Streams streams_;
  Random random_;
  RoomSet set_;
  std::vector<std::pair<Vector2d, double>> taken_;  // circles on the table
};

}  // namespace

RoomSet BuildRoom(const RoomPlan& plan) { return Furnisher(plan).Furnished(); }

}  // namespace keypose::synth
