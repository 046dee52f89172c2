// Frames through several keys on a timeline, and what they do to area and volume.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/progress.h"

namespace keypose::interpolation {

enum class Method { kArap, kPaper, kLinear };
enum class AlignKeys { kNone, kUpright, kRigid, kSimilarity };

/// Later keys brought onto the first by corresponding vertices. Upright: a turn about z and a translation. kNone changes nothing.
std::vector<PointsX3> AlignedKeys(const std::vector<PointsX3>& keys, AlignKeys align);

struct Frame {
  int segment = 0;          ///< between keys segment and segment + 1
  double t = 0;             ///< 0 at the segment's first key, 1 at its second
  PointsX3 points, linear;  ///< of the method, and of straight lines for comparison
};

struct Sequence {
  std::vector<Frame> frames;
  std::vector<int> key_frames;  ///< frame of each key; that frame has the key's own bits
  int degenerate_faces = 0;     ///< most, of any segment
  double largest_turn = 0;      ///< of any face [rad]
};

/// @param in_betweens  one number >= 0 for each pair of neighbouring keys
/// @throws InputError   fewer than two keys, keys of other sizes, unusable mesh
/// @throws SolverError, Cancelled
Sequence Interpolate(const std::vector<PointsX3>& keys, const FacesX3& faces, const std::vector<int>& in_betweens, Method method,
                     Progress* progress = nullptr);

/// Keys on a timeline: {"schema":1,"fps":24,"keys":[{"pose":"rest","time":0.0},...]}, one entry for each key, in order.
/// @return in-betweens of each pair: frames between them at `fps`, minus one
/// @throws InputError  malformed, another number of keys, times that do not rise by at least a frame; names the key
std::vector<int> InBetweensFromTimeline(const std::string& json, const std::string& name, int key_count);

}  // namespace keypose::interpolation
