// Masks that a person painted, and what photographs they were painted over.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/pictures/painted_masks.h"
#include "studio/project/originals.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// The masks that a person made for a pose's photographs.
class OwnMasks {
 public:
  /// Looks through the folder once. @pre there is such a pose; `snapshot` outlives this object
  /// @throws InputError  what is noted of the masks cannot be read
  OwnMasks(Snapshot& snapshot, const std::string& pose);

  /// The mask of a photograph; empty if there is none.
  std::filesystem::path FileOf(const std::string& name) const;
  /// Whether it was painted over another photograph of that name, so that capture leaves it out.
  bool IsOfAnother(const std::string& name) const;
  /// The mask that capture uses; empty if there is none.
  std::filesystem::path InForce(const std::string& name) const;
  const Originals& originals() const { return originals_; }

 private:
  Snapshot& snapshot_;
  Originals originals_;
  std::filesystem::path folder_;              ///< empty: the project names none
  std::vector<std::filesystem::path> files_;  ///< their names
  PaintedMasks notes_;
};

/// Writes a mask to the pose's folder of masks (masks/POSE if it has none, which then stands in
/// pipeline.yaml), and notes what it was painted over. The masks of the other photographs stay
/// computed. One that was painted over another photograph is set aside, as NAME.old.
/// @param png   8-bit, of the photograph's size
/// @param over  SHA-256 of the photograph under the brush; empty: of the one that is there
/// @return the written file
/// @throws UsageError, InputError  no such photograph, not a PNG, of another size
std::filesystem::path SaveMask(Snapshot& snapshot, const std::string& pose, const std::string& name,
                               const std::string& png, const std::string& over);

/// What becomes of masks that were painted over other photographs.
/// @param names  of the photographs
/// @param hold   true: they hold for the photographs of now; false: they are set aside as NAME.old
/// @throws UsageError  no such mask, or one that cannot hold because its size is another
void DecideMasks(Snapshot& snapshot, const std::string& pose, const std::vector<std::string>& names,
                 bool hold);

}  // namespace keypose::studio
