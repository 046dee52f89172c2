// Mattes and holdouts that a person gives, brought over the film's pictures, and what to say of
// them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "core/values/image.h"

namespace keypose::composite {

/// The picture of a matte.
struct MattePlace {
  int width = 0, height = 0;
  int orientation = 1;  ///< of its file, as EXIF counts
  std::string name;
};

/// Reads mattes of one kind, and remembers what had to be done to them.
class GivenMattes {
 public:
  /// @param stage  its name and @param what "matte" or "holdout", for messages
  GivenMattes(std::string stage, std::string what)
      : stage_(std::move(stage)), what_(std::move(what)) {}

  /// The matte over a picture of the film.
  /// @throws InputError  it cannot be read for certain, or has another shape; DiskError
  Image8 Read(const std::filesystem::path& file, const MattePlace& place);

  /// Warns of what was done to those that were read.
  void Tell(StageContext& stage) const;
  /// Whether all that cover something cover the pictures' borders, or all of a picture where nobody
  /// is: they are white where the figure is not.
  bool AreInverted() const { return surround_ > 0 && surround_ + empty_ + full_ == read_; }
  bool AreEmpty() const { return read_ > 0 && empty_ == read_; }

 private:
  std::string stage_, what_;
  std::vector<std::string> stretched_, turned_, resized_;
  int read_ = 0, surround_ = 0, empty_ = 0, full_ = 0;
};

}  // namespace keypose::composite
