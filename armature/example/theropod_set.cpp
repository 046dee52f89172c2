#include "armature/example/theropod_set.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::armature {
namespace {

using Eigen::Vector3d;
using SetColor = Eigen::Matrix<std::uint8_t, 1, 3>;

class SetBuilder {
 public:
  void Add(Mesh mesh, const Vector3d& at, const SetColor& color) {
    mesh.points.rowwise() += at.transpose();
    const Eigen::Index vertices = set_.points.rows(), faces = set_.faces.rows();
    set_.points.conservativeResize(vertices + mesh.points.rows(), 3);
    set_.points.bottomRows(mesh.points.rows()) = mesh.points;
    set_.colors.conservativeResize(set_.points.rows(), 3);
    set_.colors.bottomRows(mesh.points.rows()).rowwise() = color;
    set_.faces.conservativeResize(faces + mesh.faces.rows(), 3);
    set_.faces.bottomRows(mesh.faces.rows()) = mesh.faces.array() + static_cast<int>(vertices);
  }
  void AddBox(const Vector3d& low, const Vector3d& high, const SetColor& color) {
    const Vector3d size = high - low;
    Add(MakeBox(size.x(), size.y(), size.z()), low, color);
  }
  Mesh Take() { return std::move(set_); }

 private:
  Mesh set_;
};

/// A cone without a floor, its tip upwards.
Mesh MakeShade(double radius, double height) {
  Mesh shade = MakeCylinder(radius, height, 40, 1);
  for (Eigen::Index v = 40; v < 80; ++v) shade.points.row(v).head<2>() *= 0.35;
  return shade;
}

void AddWall(SetBuilder& set) {
  constexpr int kRows = 7, kBricks = 12;
  for (int row = 0; row < kRows; ++row)
    for (int b = -1; b < kBricks; ++b) {
      const double y = -1.5 + 0.25 * (b + 0.5 * (row % 2)), z = -0.35 + 0.2 * row;
      const auto shade = static_cast<std::uint8_t>(12 * ((b * 5 + row * 3 + 50) % 4));
      const SetColor color(static_cast<std::uint8_t>(150 - shade),
                           static_cast<std::uint8_t>(132 - shade),
                           static_cast<std::uint8_t>(118 - shade));
      set.AddBox({-0.9, y + 0.006, z + 0.006}, {-0.8, y + 0.244, z + 0.194}, color);
    }
  set.AddBox({-0.95, -3, -1}, {-0.83, 3, 2}, {96, 88, 84});
}

Mesh TableAndLamp() {
  SetBuilder set;
  for (int plank = 0; plank < 6; ++plank) {
    const auto shade = static_cast<std::uint8_t>(14 * ((plank * 7) % 3));
    const double x = -0.42 + 0.14 * plank;
    set.AddBox({x + 0.002, -0.75, -0.04}, {x + 0.138, 0.8, 0},
               {static_cast<std::uint8_t>(164 - shade), static_cast<std::uint8_t>(120 - shade),
                static_cast<std::uint8_t>(78 - shade)});
  }
  const Vector3d lamp(-0.28, 0.62, 0);
  set.Add(MakeCylinder(0.08, 0.02, 40, 1), lamp, {40, 62, 70});
  set.Add(MakeCylinder(0.012, 0.42, 20, 1), lamp, {60, 84, 92});
  set.Add(MakeShade(0.13, 0.14), lamp + Vector3d(0, 0, 0.38), {204, 170, 84});
  return set.Take();
}

}  // namespace

Mesh MakeTheropodSet() { return TableAndLamp(); }

FilmedShot MakeTheropodShot(int width, int height, int frames) {
  FilmedShot shot;
  shot.camera.width = width;
  shot.camera.height = height;
  shot.camera.fx = shot.camera.fy = 1.25 * width;
  shot.camera.cx = 0.5 * width;
  shot.camera.cy = 0.5 * height;
  shot.fps = 24;
  for (int f = 0; f < frames; ++f) {
    ShotFrame frame;
    frame.frame = f;
    frame.picture = "plate.png";
    frame.camera_from_world = LookAt(Vector3d(1.6, 0.55, 0.5), Vector3d(0, 0.02, 0.2));
    frame.method = "given";
    shot.frames.push_back(frame);
  }
  return shot;
}

Image8 MakeTheropodPlate(const FilmedShot& shot) {
  SetBuilder set;
  AddWall(set);
  set.Add(TableAndLamp(), Vector3d::Zero(), {0, 0, 0});
  Mesh whole = set.Take();
  const Mesh table = TableAndLamp();
  whole.colors.bottomRows(table.colors.rows()) = table.colors;
  View view;
  view.camera = shot.camera;
  view.camera_from_world = shot.frames.front().camera_from_world;
  RenderOptions options;
  options.smooth = false;
  options.background = {70, 66, 64};
  return Render(whole, view, options);
}

}  // namespace keypose::armature
