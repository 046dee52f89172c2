// Damages folders of photographs in realistic ways, for tests of bad input.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::synth {

enum class DamageKind {
  kTruncate,    ///< the file's second half is lost
  kEmpty,       ///< no bytes
  kNoImage,     ///< a text file with an image's name
  kBlur,        ///< out of focus, 6 px
  kDark,        ///< only the sensor's black level
  kDrop,        ///< the file is missing
  kRotate,      ///< stored rotated by 90 degrees, with the EXIF orientation that corrects it
  kUpsideDown,  ///< rotated by 180 degrees, without an EXIF orientation
  kResize,      ///< 80 % of the size
  kStripExif,   ///< no camera, no focal length
  kHand,        ///< a hand covers the middle
  kTool,        ///< a modelling tool reaches across the middle
  kThumb,       ///< a thumb before the lens
};

/// @throws UsageError  unknown word; lists the known ones
DamageKind DamageKindNamed(const std::string& word);

/// Copies a folder of photographs and damages some of the copies.
///
/// @param names  names of the files to damage; empty: all
/// @throws InputError  a name is not in the folder @throws DiskError
void DamagePhotos(const std::filesystem::path& from, const std::filesystem::path& to,
                  DamageKind kind, const std::vector<std::string>& names);

}  // namespace keypose::synth
