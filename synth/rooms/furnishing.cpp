#include "synth/rooms/furnishing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/values/angles.h"
#include "synth/rooms/printed.h"
#include "synth/rooms/surfaces.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Rigid3 Placed(const Vector3d& at, double turn_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ())), at};
}

/// A wall with pictures. `corner` is its upper left one, seen from within.
void AddWall(Furniture& room, const Vector3d& corner, const Vector3d& across, double high,
             Streams& streams) {
  const double wide = across.norm();
  const Vector3d down(0, 0, -high), right = across / wide, in = down.cross(across).normalized();
  room.Add({corner, across, down, room.AddPrint(WallPrint(wide, high, streams.Next())), Part::kRoom,
            0.15, false});
  Random random = streams.Next();
  double x = random.Uniform(0.05, 0.3);
  while (true) {
    const double w = random.Uniform(0.25, 0.7), h = w * random.Uniform(0.7, 1.35);
    if (x + w > wide - 0.05) break;
    const double top = random.Uniform(0.08, std::max(0.1, high - h - 0.9));
    Print print = random.Uniform() < 0.7 ? PaintingPrint(w, h, streams.Next())
                                         : PosterPrint(w, h, streams.Next());
    const Vector3d hung = corner + x * right - top * Vector3d::UnitZ() + 0.012 * in;
    room.Add({hung, w * right, Vector3d(0, 0, -h), room.AddPrint(std::move(print)), Part::kRoom,
              0.15, false});
    x += w + random.Uniform(0.08, 0.5);
  }
}

int AddSpare(Furniture& room, const Vector3d& size, Streams& streams) {
  const double most = std::max({size.x(), size.y(), size.z()});
  return room.AddPrint(PaintPrint(most, most, streams.Next()));
}

/// One upright book whose front lower left corner is at `at` of the shelf.
void AddBook(Furniture& room, const Rigid3& room_from_shelf, const Vector3d& at,
             const Vector3d& size, double lean_rad, Streams& streams) {
  const int spine = room.AddPrint(SpinePrint(size.x(), size.z(), streams.Next())),
            pages = room.AddPrint(PagesPrint(size.x(), size.y(), streams.Next())),
            side = AddSpare(room, size, streams);
  const Rigid3 leaning{Eigen::Quaterniond(Eigen::AngleAxisd(lean_rad, Vector3d::UnitY())), at};
  const Rigid3 box = Compose(leaning, {Eigen::Quaterniond::Identity(), size / 2});
  room.AddBox(Compose(room_from_shelf, box), size, {spine, -1, side, side, pages, -1}, Part::kRoom,
              0.06);
}

/// A row of books from x = `from` to `to`.
void FillBoard(Furniture& room, const Rigid3& room_from_shelf, double from, double to, double foot,
               double clear, double deep, Streams& streams) {
  Random random = streams.Next();
  double x = from + 0.004;
  while (x < to - 0.05) {
    if (random.Uniform() < 0.10) {  // a box, or a gap
      const double w = random.Uniform(0.07, 0.13), h = clear * random.Uniform(0.3, 0.75);
      if (x + w > to) break;
      const int front = room.AddPrint(LabelPrint(w, h, streams.Next()));
      const int side = AddSpare(room, {w, deep, h}, streams);
      const Rigid3 box = Placed({x + w / 2, 0.02 + 0.35 * deep, foot + h / 2}, 0.1 * (w - 0.1));
      if (random.Uniform() < 0.7)
        room.AddBox(Compose(room_from_shelf, box), {w, 0.7 * deep, h},
                    {front, -1, side, side, side, -1}, Part::kRoom, 0.06);
      x += w + 0.01;
      continue;
    }
    const Vector3d size(random.Uniform(0.012, 0.045), deep * random.Uniform(0.6, 0.92),
                        clear * random.Uniform(0.62, 0.93));
    const bool leans = random.Uniform() < 0.08;
    const double lean = leans ? random.Uniform(0.05, 0.16) : 0;
    if (x + size.x() + size.z() * std::sin(lean) > to) break;
    AddBook(room, room_from_shelf, {x, random.Uniform(0.004, 0.05), foot}, size, lean, streams);
    x += size.x() + size.z() * std::sin(lean) + random.Uniform(0.0005, 0.003);
  }
}

}  // namespace

void AddWalls(Furniture& room, const Vector3d& low, const Vector3d& high, Streams& streams) {
  const double wide = high.x() - low.x(), deep = high.y() - low.y(), tall = high.z() - low.z();
  const Vector3d x(wide, 0, 0), y(0, deep, 0);
  AddWall(room, {low.x(), high.y(), high.z()}, x, tall, streams);
  AddWall(room, {high.x(), low.y(), high.z()}, -x, tall, streams);
  AddWall(room, {low.x(), low.y(), high.z()}, y, tall, streams);
  AddWall(room, {high.x(), high.y(), high.z()}, -y, tall, streams);
  Random random = streams.Next();
  Print floor = random.Uniform() < 0.5 ? CarpetPrint(wide, deep, streams.Next())
                                       : BoardsPrint(wide, deep, 0.12, streams.Next());
  room.Add({{low.x(), high.y(), low.z()},
            x,
            -y,
            room.AddPrint(std::move(floor)),
            Part::kRoom,
            0.2,
            false});
  room.Add({{low.x(), low.y(), high.z()},
            x,
            y,
            room.AddPrint(PaintPrint(wide, deep, streams.Next())),
            Part::kRoom,
            0.4,
            false});
}

void AddShelf(Furniture& room, const Rigid3& room_from_shelf, const Vector3d& size,
              Streams& streams) {
  constexpr double kBoard = 0.018;
  const int wood = room.AddPrint(BoardsPrint(size.x(), 0.35, 0.09, streams.Next()));
  const int back = room.AddPrint(BoardsPrint(size.x(), size.z(), 0.2, streams.Next()));
  const std::array<int, 6> all = {wood, wood, wood, wood, wood, wood};
  room.Add({room_from_shelf * Vector3d(0, size.y(), size.z()),
            room_from_shelf.rotation * Vector3d(size.x(), 0, 0), Vector3d(0, 0, -size.z()), back,
            Part::kRoom, 0.08, false});
  const auto board = [&](const Vector3d& middle, const Vector3d& measure) {
    room.AddBox(Compose(room_from_shelf, {Eigen::Quaterniond::Identity(), middle}), measure, all,
                Part::kRoom, 0.08);
  };
  for (const double x : {kBoard / 2, size.x() - kBoard / 2})
    board({x, size.y() / 2, size.z() / 2}, {kBoard, size.y(), size.z()});
  const int rows = std::max(1, static_cast<int>(std::lround(size.z() / 0.29)));
  for (int row = 0; row <= rows; ++row) {
    const double foot = row * (size.z() - kBoard) / rows;
    board({size.x() / 2, size.y() / 2, foot + kBoard / 2},
          {size.x() - 2 * kBoard, size.y(), kBoard});
    if (row < rows)
      FillBoard(room, room_from_shelf, kBoard, size.x() - kBoard, foot + kBoard,
                (size.z() - kBoard) / rows - kBoard, size.y(), streams);
  }
}

void AddTable(Furniture& room, const Vector3d& middle, double wide, double deep, Streams& streams) {
  Random random = streams.Next();
  const bool cloth = random.Uniform() < 0.7;
  const double hang = cloth ? random.Uniform(0.1, 0.25) : 0.04;
  const Vector3d x(wide, 0, 0), y(0, deep, 0), down(0, 0, -hang);
  const PrintRandom look = streams.Next();
  const auto print = [&](double w, double h) {
    return room.AddPrint(cloth ? ClothPrint(w, h, look) : BoardsPrint(w, h, 0.11, look));
  };
  room.Add({middle + (y - x) / 2, x, -y, print(wide, deep), Part::kTable, 0.012, true});
  const int front = print(wide, hang), side = print(deep, hang);
  room.Add({middle - (x + y) / 2, x, down, front, Part::kRoom, 0.08, false});
  room.Add({middle + (x + y) / 2, -x, down, front, Part::kRoom, 0.08, false});
  room.Add({middle + (y - x) / 2, -y, down, side, Part::kRoom, 0.08, false});
  room.Add({middle + (x - y) / 2, y, down, side, Part::kRoom, 0.08, false});
}

void AddLyingBook(Furniture& room, const Vector3d& at, const Vector3d& size, double turn_rad,
                  Part part, Streams& streams) {
  const Rigid3 placed = Placed(at, turn_rad);
  const int cover = room.AddPrint(CoverPrint(size.x(), size.y(), streams.Next())),
            pages =
                room.AddPrint(PagesPrint(std::max(size.x(), size.y()), size.z(), streams.Next()));
  // The spine's print stands upright; turned, it lies along the book's front.
  Print spine = LabelPrint(size.x(), size.z(), streams.Next());
  const int back = room.AddPrint(std::move(spine));
  room.AddBox(Compose(placed, {Eigen::Quaterniond::Identity(), {0, 0, size.z() / 2}}), size,
              {back, pages, pages, pages, -1, -1}, part, 0.03);
  room.Add({placed * Vector3d(-size.x() / 2, size.y() / 2, size.z()),
            placed.rotation * Vector3d(size.x(), 0, 0), placed.rotation * Vector3d(0, -size.y(), 0),
            cover, part, 0.02, part == Part::kSupport});
}

double AddThing(Furniture& room, ThingKind kind, const Rigid3& room_from_thing, Part part,
                PrintRandom random) {
  if (kind == ThingKind::kMug || kind == ThingKind::kTin) {
    const bool mug = kind == ThingKind::kMug;
    const double radius = mug ? random.Uniform(0.032, 0.042) : random.Uniform(0.024, 0.034),
                 height = mug ? random.Uniform(0.075, 0.1) : random.Uniform(0.05, 0.12);
    const int side = room.AddPrint(LabelPrint(2 * kPi * radius, height, random)),
              lid = room.AddPrint(PaintPrint(2 * radius, 2 * radius, random));
    room.AddDrum(room_from_thing, radius, height, side, lid, part);
    return radius;
  }
  const double side = random.Uniform(0.035, 0.05);
  const Vector3d size = kind == ThingKind::kBlock
                            ? Vector3d::Constant(side)
                            : Vector3d(random.Uniform(0.05, 0.09), random.Uniform(0.03, 0.05),
                                       random.Uniform(0.06, 0.13));
  std::array<int, 6> prints{};
  for (int i = 0; i < 6; ++i) {
    const PrintRandom own(Hash(random.Below(1 << 30) + i), random.detail);
    const double w = i == 2 || i == 3 ? size.y() : size.x(), h = i < 4 ? size.z() : size.y();
    prints[i] =
        room.AddPrint(kind == ThingKind::kBlock ? BlockPrint(side, own) : LabelPrint(w, h, own));
  }
  room.AddBox(Compose(room_from_thing, {Eigen::Quaterniond::Identity(), {0, 0, size.z() / 2}}),
              size, prints, part, 0.02);
  return std::hypot(size.x(), size.y()) / 2;
}

void AddTree(Furniture& room, const Vector2d& at, double radius, double low, double high,
             PrintRandom random) {
  constexpr int kAround = 96;
  const int along = std::max(8, static_cast<int>((high - low) / 0.03));
  const int bark =
      room.AddPrint(BarkPrint(2 * kPi * radius, high - low, at.norm() < 1 ? 900 : 320, random));
  const std::uint32_t seed = static_cast<std::uint32_t>(random.Below(1 << 24));
  const Vector2d bend(random.Uniform(-0.06, 0.06), random.Uniform(-0.06, 0.06));
  std::vector<std::vector<Vector3d>> rows;
  std::vector<std::vector<Vector2d>> places;
  for (int j = 0; j <= along; ++j) {
    const double z = high - (high - low) * j / along;
    rows.emplace_back();
    places.emplace_back();
    for (int i = 0; i <= kAround; ++i) {
      const double angle = 2 * kPi * (i % kAround) / kAround;
      const Vector3d out(std::cos(angle), std::sin(angle), 0);
      const double rough =
          FractalNoise({out.x() * radius / 0.05, out.y() * radius / 0.05, z / 0.2}, 4, 0.55, seed);
      const double foot = 0.6 * std::exp(-(z - low) / 0.12);
      const double r = radius * (1 + 0.11 * rough + foot);
      const Vector2d shift = at + z * bend;
      rows.back().push_back(Vector3d(shift.x(), shift.y(), z) + r * out);
      places.back().emplace_back(2 * kPi * radius * i / kAround, (high - low) * j / along);
    }
  }
  room.AddPatch(rows, places, bark, Part::kRoom, true);
}

}  // namespace keypose::synth
