// A puppet from its files, and the plates and cameras of its shot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "armature/live/plate_view.h"
#include "armature/live/posed_puppet.h"
#include "core/stage/stage.h"
#include "core/values/options.h"

namespace keypose::armature {

/// What a puppet is read from; empty paths are not given.
struct PuppetPaths {
  std::filesystem::path description, chains;
  std::filesystem::path skeleton;  ///< .bvh; none: like the armature itself
  std::filesystem::path mesh;      ///< none: ball and stick
  std::filesystem::path weights;   ///< .json, .mhw, .dmat; none: by heat
};

/// The inputs of a stage that reads a puppet, and the files that it was given for them.
std::vector<Port> PuppetPorts();
PuppetPaths PuppetPathsIn(const StageContext& stage);

/// Options that `live` and `bake` have in common.
struct PuppetChoices {
  std::string method = "both_ends", unreachable = "near", armature_up = "z", skeleton_up = "z";
  double calm = 0;

  void Describe(OptionVisitor& visit);
};

struct LoadedPuppet {
  PuppetParts parts;
  std::vector<std::string> notes, warnings;
  /// That the mesh is not where the skeleton is, or not of its size, in words; "" if it is. Also
  /// among the warnings.
  std::string misplaced;
};

/// @throws InputError  malformed files, parts that do not fit each other; names them
LoadedPuppet LoadPuppet(const PuppetPaths& paths, const PuppetChoices& choices);

/// Plates and cameras, one after another. With neither file there is one view that shows the whole
/// puppet at rest before a backdrop.
class PlateFiles {
 public:
  /// @param plate  picture, folder of pictures, or empty
  /// @param shot   shot.json, or empty
  /// @param rest   of the puppet, for the view that shows it if there is no shot
  /// @throws InputError  a plate of another size than the shot's camera
  PlateFiles(const std::filesystem::path& plate, const std::filesystem::path& shot,
             const PointsX3& rest);
  int count() const { return count_; }
  const std::vector<std::filesystem::path>& pictures() const { return plates_; }
  /// Without pictures; one for all plates, or one for each: that of the located frame which is
  /// nearest to the plate by its number.
  const std::vector<PlateView>& views() const { return views_; }
  /// @param index  beyond the last: the last
  PlateView Read(int index) const;

 private:
  std::vector<std::filesystem::path> plates_;
  std::vector<PlateView> views_;
  int count_ = 1;
};

}  // namespace keypose::armature
