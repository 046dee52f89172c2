// Masks of a shot as people have them: of any two levels, in alpha, inverted, of another size.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "views/shot/shot.h"

namespace keypose {

/// Reads one camera's masks, bright where the actor is.
///
/// A few frames tell how they were made, as a program writes all of them alike. Masks that are
/// white on black are read as they are, with soft borders; others frame by frame by their levels
/// (see ReadDrawnMask), or all by their alpha where that is a mask in one of those looked at. Not
/// for use in several threads at once.
class GivenMasks {
 public:
  /// @param stage  for messages
  /// @throws InputError  several labels, colours, dark all over: which level is the actor cannot be
  /// known; names the file
  GivenMasks(const ShotCamera& camera, const std::string& stage);

  /// 255 where the actor is, H x W.
  /// @throws InputError  as FrameReader::Read; another shape than it should have
  Image8 Read(int frame);

  /// From now on masks are brought to this size: of the camera's pictures.
  /// @param orientation  of their files, as EXIF counts
  void FitTo(int width, int height, int orientation);

  /// What is to be said of them: sentences for warnings.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::filesystem::path FileOf(int frame) const;
  /// One of a film, which is decoded for it once.
  struct Filmed {
    Image8 luma, alpha;  // alpha: no picture where there is none
  };
  /// Of frames that were looked at.
  struct Tally {
    int looked = 0, empty = 0, full = 0, surround = 0;
  };
  bool is_film() const { return !source_.video.empty(); }
  bool IsByAlpha(const Image8& alpha) const;
  Filmed ReadFilmed(int frame);
  Image8 Drawn(const Filmed& filmed) const;
  Image8 DrawnPicture(int frame) const;
  Tally LookAtFilm(const std::set<int>& frames);
  Tally LookAtPictures(const std::set<int>& frames);
  void LookAt(const Image8& plain, const Image8& drawn, Tally* tally);

  std::string name_, stage_;  // of the camera, of the program
  FrameSource source_;
  FrameReader reader_;
  bool drawn_ = false;     // must be read by levels or alpha
  bool alpha_ = false;     // alpha is the mask, also of frames that are opaque all over
  bool inverted_ = false;  // white is what is not the actor
  bool fitted_ = false;
  int width_ = 0, height_ = 0, orientation_ = 1;
  std::vector<std::string> warnings_;
};

}  // namespace keypose
