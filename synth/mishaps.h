// What goes wrong at the set between the first photograph and the last: a photograph of something
// else, a figure that was moved, a hand in the picture, a lamp that fell over.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace keypose::synth {

/// Which of a pose's photographs went wrong, and how. A pure function of the options: nothing here
/// is random.
struct Mishaps {
  int strays = 0;  ///< photographs that show another character, taken from the same rig
  std::uint64_t stray_seed = 0;  ///< that character; 0: the one after the world's own
  int hands = 0;  ///< photographs with a forearm that reaches in from the border and covers part of
                  ///< the figure
  double moved_from = 1;   ///< share of the photographs after which the figure was bumped; 1: never
  double moved_m = 0;      ///< along the table, towards +x
  double moved_rad = 0;    ///< about the turntable's axis
  std::string moved_pose;  ///< the figure took this pose instead; "": it kept its own
  double lamp_falls_after = 1;  ///< share of the photographs after which the lamp lies on the other
                                ///< side, near the table; 1: never
  double fallen_aside_rad = 1.2;  ///< of the fallen lamp from the camera, about z
  double fallen_elevation_deg = 12;

  bool any() const { return strays > 0 || hands > 0 || moved_from < 1 || lamp_falls_after < 1; }
  /// One sentence per fault; empty when valid.
  /// @param views  photographs of a pose
  std::vector<std::string> Problems(int views) const;
};

/// Of the character that stray photographs show.
std::uint64_t StraySeed(const Mishaps& mishaps, std::uint64_t world_seed);
/// Indices of the photographs that show something else, spread over the set. Ascending.
std::vector<int> StrayViews(const Mishaps& mishaps, int views);
/// Indices of the photographs with a hand in them, spread over the set, none of them a stray one.
/// Ascending.
std::vector<int> HandViews(const Mishaps& mishaps, int views);
/// The first photograph after a share of them.
int FirstAfter(double share, int views);

/// Reads "0.5:5mm,7deg" or "0.5:bent" into moved_from, moved_m, moved_rad and moved_pose.
/// @throws UsageError  another form
void ReadMove(const std::string& text, Mishaps* mishaps);

}  // namespace keypose::synth
