// Things of a room with printed surfaces: sheets, boxes, drums, curved patches; one mesh, lit.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "synth/rooms/print.h"

namespace keypose::synth {

/// Light of a room: a large lamp far away, and what comes from all sides.
struct RoomLight {
  double azimuth_rad = 0, elevation_rad = 0.9;  ///< of the lamp
  double lamp = 0.7, ambient = 0.45;            ///< on white, linear
  double gloss = 0.03;                          ///< of clay
  Eigen::Vector3d Direction() const;            ///< unit, to the lamp
};

/// What covers a pixel, as the truth writes it.
enum class Part : std::uint8_t {
  kRoom = 0,       ///< stands still: walls, shelf, floor
  kHand = 60,      ///< of a person, before everything
  kTable = 100,    ///< the table's top
  kSupport = 140,  ///< moves with the figure and carries it: mat, disc, book
  kThing = 180,    ///< another thing that moves with the figure
  kFigure = 255
};

/// A flat rectangle with a print.
struct Sheet {
  Eigen::Vector3d corner;        ///< [m] of the print's upper left corner
  Eigen::Vector3d across, down;  ///< [m] along the sheet, to the right and down on the print
  int print = 0;                 ///< of Furniture::AddPrint
  Part part = Part::kRoom;
  double cell_m = 0.1;  ///< light is computed at points so far apart
  bool ground = false;  ///< gets shadows of what stands on it
};

class Furniture {
 public:
  int AddPrint(Print print);
  const Print& print(int i) const { return *prints_[i]; }
  void Add(const Sheet& sheet);
  /// A box with its own prints, which are cut to its sides.
  /// @param room_from_box  the box has its middle at the origin
  /// @param prints  front (-y), back, left (-x), right, top, bottom; -1: open
  void AddBox(const Rigid3& room_from_box, const Eigen::Vector3d& size,
              const std::array<int, 6>& prints, Part part, double cell_m = 0.05);
  /// An upright round body from z = 0 of its frame. `side` runs around it from -y, `lid` is cut to
  /// its top; -1: none.
  void AddDrum(const Rigid3& room_from_drum, double radius, double height, int side, int lid,
               Part part, bool ground_lid = false);
  /// A curved patch: rows of points, with smooth normals on the side where the rows run to the
  /// left when the columns run up.
  /// @param places  per point, on the print [m]
  /// @param closed  the last column is the first once more, for the normals
  void AddPatch(const std::vector<std::vector<Eigen::Vector3d>>& rows,
                const std::vector<std::vector<Eigen::Vector2d>>& places, int print, Part part,
                bool closed = false);

  /// Ends building: rays can be cast. @throws InputError  nothing was added
  void Finish();
  bool empty() const { return faces_.empty(); }
  const RayScene& scene() const { return *scene_; }
  /// All faces; for other scenes.
  Mesh AsMesh() const;
  /// The same without sheets that are ground.
  Mesh Standing() const;
  /// Shares of lamp and room that each point gets, where these scenes stand in the way.
  /// @param turns   the lamp's direction changes: it is seen from everywhere
  /// @param ground  also those of ground
  void Light(const std::vector<const RayScene*>& blockers, const RoomLight& light, bool turns,
             bool ground);

  Part PartOf(int face) const { return part_[face]; }
  bool IsGround(int face) const { return ground_[face] != 0; }
  /// A number that is the same for all faces of one sheet, side or patch.
  int PieceOf(int face) const { return piece_[face]; }
  const Eigen::Vector3d& FaceNormal(int face) const { return face_normal_[face]; }

  /// Light that leaves towards the eye.
  struct Look {
    Eigen::Vector3d ray;                    ///< the hit is eye + hit.distance * ray
    double pixel_m = 0.001;                 ///< size of a pixel at the hit, across the ray
    Eigen::Vector3d to_lamp;                ///< unit, in this furniture's frame
    double lamp_share = 1, room_share = 1;  ///< what others leave of the light
  };
  Eigen::Vector3d Shade(const RayScene::Hit& hit, const Look& look, const RoomLight& light) const;

 private:
  void Face(int a, int b, int c, int print, Part part, bool ground);
  int Point(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
            const Eigen::Vector2d& place);
  Eigen::Vector3d Color(int face, const Eigen::Vector2d& place, const Look& look,
                        const Eigen::Vector3d& normal) const;

  std::vector<std::shared_ptr<const Print>> prints_;
  std::vector<Eigen::Vector3d> points_, normals_, face_normal_;
  std::vector<Eigen::Vector2d> places_;  // on the print [m]
  std::vector<std::array<int, 3>> faces_;
  std::vector<Eigen::Matrix<double, 2, 3>> place_from_step_;
  std::vector<int> print_, piece_;
  std::vector<Part> part_;
  std::vector<std::uint8_t> ground_, ground_point_;
  std::vector<float> lamp_, room_;  // per point
  std::unique_ptr<RayScene> scene_;
  int pieces_ = 0;
};

}  // namespace keypose::synth
