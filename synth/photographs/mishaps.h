// Mishaps while photographing: a photograph of another object, a moved figure, a hand in the
// picture, a fallen lamp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace keypose::synth {

/// Which photographs of a pose go wrong, and how. Nothing here is random.
struct Mishaps {
  int strays = 0;  ///< photographs that show another character, taken from the same rig
  std::uint64_t stray_seed = 0;  ///< seed of that character; 0: the seed after the world's
  /// photographs with a forearm that enters from the border and covers part of the figure
  int hands = 0;
  double moved_from = 1;   ///< share of the photographs after which the figure was bumped; 1: never
  double moved_m = 0;      ///< along the table, towards +x
  double moved_rad = 0;    ///< about the turntable's axis
  std::string moved_pose;  ///< the figure takes this pose instead; "": no change
  /// share of the photographs after which the lamp lies low on the other side; 1: never
  double lamp_falls_after = 1;
  double fallen_aside_rad = 1.2;  ///< azimuth of the fallen lamp relative to the camera, about z
  double fallen_elevation_deg = 12;

  bool any() const { return strays > 0 || hands > 0 || moved_from < 1 || lamp_falls_after < 1; }
  /// One sentence per fault; empty when valid.
  /// @param views  photographs of a pose
  std::vector<std::string> Problems(int views) const;
};

/// Seed of the character in stray photographs.
std::uint64_t StraySeed(const Mishaps& mishaps, std::uint64_t world_seed);
/// Indices of the stray photographs, spread over the set, ascending.
std::vector<int> StrayViews(const Mishaps& mishaps, int views);
/// Indices of the photographs with a hand, spread over the set, none of them stray, ascending.
std::vector<int> HandViews(const Mishaps& mishaps, int views);
/// Index of the first photograph after this share of all.
int FirstAfter(double share, int views);

/// Reads "0.5:5mm,7deg" or "0.5:bent" into moved_from, moved_m, moved_rad and moved_pose.
/// @throws UsageError  the text has another form
void ReadMove(const std::string& text, Mishaps* mishaps);

}  // namespace keypose::synth
