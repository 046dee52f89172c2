// The photographs in a pose's folder, under the names that capture gives them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Names of the photographs in a pose's folder, as capture takes them: a RAW file counts if no
/// other photograph has its stem.
std::vector<std::string> OriginalPhotographs(const std::filesystem::path& folder);

/// Reads the header only; of a RAW file too. Upright.
/// @throws DiskError, InputError  it cannot be read
ImageInfo OriginalInfo(const std::filesystem::path& file);

class Originals {
 public:
  /// Looks through the folder once. @pre there is such a pose; `snapshot` outlives this object
  Originals(Snapshot& snapshot, const std::string& pose);

  /// The file of that name, or of which capture makes the photograph of that name: it writes RAW
  /// and HEIC files as JPEG, and puts the name of a subfolder before those of its photographs.
  /// Empty if there is none, or if it is a link that leads out of the folder.
  std::filesystem::path FileOf(const std::string& name) const;
  /// SHA-256 of that file; empty if there is none.
  std::string HashOf(const std::string& name) const;
  /// Whether capture read another file of that name: the photograph was shot again since.
  bool WasShotAgain(const std::string& name) const;

 private:
  Snapshot& snapshot_;
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;  ///< relative to the folder
  /// what capture read last; null: nothing yet
  std::optional<pipeline::Content> captured_;
};

}  // namespace keypose::studio
