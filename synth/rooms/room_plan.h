// What a generated room is like: chosen by its seed, where nobody says otherwise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "synth/rooms/furniture.h"

namespace keypose::synth {

/// What moves, and who holds the camera.
enum class RoomKind {
  kWalk,     ///< the camera walks around a still world
  kMat,      ///< a printed mat turns with the figure before a still room; camera on a tripod
  kMatHand,  ///< the same with the camera in the hand
  kBoth,     ///< a ring on the mat, then close-ups by hand, held the other way up
  kOneSide,  ///< a few photographs of one side, walking
  kTrunk,    ///< a carving in a tree: not free-standing
  kRelief    ///< a relief on a wall: not free-standing
};
/// walk, mat, mat-hand, both, one-side, trunk, relief.
/// @throws UsageError  another name
RoomKind RoomKindNamed(const std::string& name);
std::string NameOf(RoomKind kind);

/// Empty texts and negative numbers leave the choice to the seed.
struct RoomOptions {
  std::uint64_t seed = 1;  ///< of everything; 1 to 24 hold all kinds of free-standing figures
  std::string kind;
  int photographs = 0;             ///< 0: by the kind
  int width = 1200, height = 800;  ///< of a photograph held level [px]
  std::string second;              ///< none | apart | touching: another thing beside the figure
  int hands = -1;                  ///< photographs with a person's hand
  std::string exif;                ///< yes | no
  int lenses = -1;                 ///< 1 or 2; 2 only where there are close-ups
  std::string texture;             ///< rich | weak: contrast of the figure's paint
  double noise = 1;                ///< of the sensor; 1: an ordinary camera
  double spacing_m = 0.003;        ///< of the figure's surface
  double detail = 1;               ///< of all prints; 1: for photographs of 1 to 2 megapixels
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

struct RoomPlan {
  RoomKind kind = RoomKind::kWalk;
  std::uint64_t seed = 1;
  int photographs = 36, width = 1200, height = 800, hands = 0, lenses = 1;
  std::string second = "none", support = "cloth";  ///< cloth | book | mat | disc | trunk | wall
  bool exif = true;
  bool portrait_first = false;  ///< the ring, of kBoth, is held upright; otherwise the close-ups
  std::string character = "creature", pose = "rest", texture = "rich";
  std::uint64_t figure_seed = 1;
  double noise = 1, spacing_m = 0.003, detail = 1;
  double focal_35mm[2] = {35, 50};
  RoomLight light;

  bool turns() const {
    return kind == RoomKind::kMat || kind == RoomKind::kMatHand || kind == RoomKind::kBoth;
  }
  bool free_standing() const { return kind != RoomKind::kTrunk && kind != RoomKind::kRelief; }
};

/// Reads "1200x800".
/// @throws UsageError  another form
void ReadSize(const std::string& text, int* width, int* height);

/// @throws UsageError  a fault in the options
RoomPlan PlanRoom(const RoomOptions& options);

}  // namespace keypose::synth
