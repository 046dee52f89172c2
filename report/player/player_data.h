// Compact data for the page's player: quantised positions of some frames, one layout of faces and
// UVs, textures as JPEG.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::report {

/// One picture of the animation: its place between two stored frames, and the weight of each
/// texture.
struct PlayerMoment {
  int a = 0, b = 0;
  double share = 0;             ///< of the way from a to b
  std::vector<double> weights;  ///< one per texture
};

struct PlayerData {
  Mesh mesh;                     ///< faces and UVs; its positions are not used
  std::vector<PointsX3> frames;  ///< the stored frames
  std::vector<PlayerMoment> moments;
  std::vector<int> keys;         ///< stored frames that are keys
  std::vector<Image8> textures;  ///< one per pose
  double fps = 24;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

/// The frames to store if at most `most` are allowed: all keys, and others evenly spaced.
/// Ascending.
/// @param repeats  for each frame the earlier frame that it repeats, or itself
/// @param keys     for each frame whether it is a key
std::vector<int> FramesToStore(const std::vector<int>& repeats, const std::vector<char>& keys,
                               std::size_t most);

/// For each frame the two stored frames around it.
/// @param stored  ascending, not empty
std::vector<PlayerMoment> MomentsOf(const std::vector<int>& repeats,
                                    const std::vector<int>& stored);

/// Weight of each pose's texture at `t`: the key's number plus the share of the way to the next.
/// @param pose_of_key  index of the pose of each key
std::vector<double> TextureWeights(double t, const std::vector<int>& pose_of_key,
                                   std::size_t poses);

/// The JSON that report/player/data.js unpacks.
/// @param encode  encodes a picture as a data URI
std::string PlayerJson(const PlayerData& data,
                       const std::function<std::string(const Image8&)>& encode);

/// The bundled script of the player.
const char* PlayerScript();

}  // namespace keypose::report
