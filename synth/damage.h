// Spoils folders of photographs the way that real ones are spoilt, for tests of bad input.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::synth {

enum class DamageKind {
  kTruncate,    ///< the file's second half is lost
  kEmpty,       ///< no bytes
  kNoImage,     ///< a text under an image's name
  kBlur,        ///< out of focus, 6 px
  kDark,        ///< nothing but the sensor's black
  kDrop,        ///< the file is gone
  kRotate,      ///< stored on its side, with the EXIF orientation that stands it up again
  kUpsideDown,  ///< turned by 180 degrees, and no EXIF orientation that tells
  kResize,      ///< 80 % of the size
  kStripExif,   ///< no camera, no focal length
};

/// @throws UsageError  unknown word; lists those there are
DamageKind DamageKindNamed(const std::string& word);

/// Copies a folder of photographs and spoils some of the copies.
///
/// @param names  file names to spoil; empty: all
/// @throws InputError  a name that is not in the folder @throws DiskError
void DamagePhotos(const std::filesystem::path& from, const std::filesystem::path& to,
                  DamageKind kind, const std::vector<std::string>& names);

}  // namespace keypose::synth
