// What the page's player shows, made compact: quantised positions of some frames, one layout of
// faces and UVs, textures as JPEG.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"

namespace keypose::report {

/// One picture of the animation: between two stored frames, and how much of each texture.
struct PlayerMoment {
  int a = 0, b = 0;
  double share = 0;             ///< of the way from a to b
  std::vector<double> weights;  ///< one a texture
};

struct PlayerData {
  Mesh mesh;                     ///< faces and UVs; its positions are not used
  std::vector<PointsX3> frames;  ///< those that are stored
  std::vector<PlayerMoment> moments;
  std::vector<int> keys;         ///< stored frames that are keys
  std::vector<Image8> textures;  ///< one a pose
  double fps = 24;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

/// Which frames to store when no more than `most` may be: all keys, and the others evenly.
/// Ascending.
/// @param repeats  for each frame the earlier one that it shows again, or itself
/// @param keys     for each frame whether it is a key
std::vector<int> FramesToStore(const std::vector<int>& repeats, const std::vector<char>& keys,
                               std::size_t most);

/// For each frame the two stored ones around it.
/// @param stored  ascending, not empty
std::vector<PlayerMoment> MomentsOf(const std::vector<int>& repeats,
                                    const std::vector<int>& stored);

/// Share of each pose's texture at `t`, the key's number plus the share of the way to the next.
/// @param pose_of_key  index of the pose of each key
std::vector<double> TextureWeights(double t, const std::vector<int>& pose_of_key,
                                   std::size_t poses);

/// The JSON that report/player/data.js unpacks.
/// @param encode  a picture as data URI
std::string PlayerJson(const PlayerData& data,
                       const std::function<std::string(const Image8&)>& encode);

/// The player's program, bundled.
const char* PlayerScript();

}  // namespace keypose::report
