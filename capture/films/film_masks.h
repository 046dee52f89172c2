// Masks of an actor in one fixed camera's film, without a picture of the empty set.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "capture/films/film_model.h"
#include "capture/films/network_looks.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Frames of a film that are learnt from, at working size.
struct FilmSample {
  std::vector<int> frames;       ///< their numbers, ascending
  std::vector<Image8> pictures;  ///< RGB, all of one size
};

/// What a person said in one frame, at working size.
struct ToldFrame {
  int frame = 0;
  Image8 trimap;  ///< see capture/segmentation/trimap.h
};

/// The frames to learn from: evenly spread, and those of which something is told.
std::vector<int> FramesToLearnFrom(int frames, const std::vector<ToldFrame>& told);

/// A camera's film, learnt. Same bits for any thread count.
class FilmMasker {
 public:
  /// @param network  may be empty; asked for a few frames, and again for some when the actor is
  /// known
  /// @throws InputError  nothing moves, and neither the network nor a person says what the actor is
  FilmMasker(FilmSample sample, const std::vector<ToldFrame>& told, const AskNetwork& network,
             const FilmMaskOptions& options);
  ~FilmMasker();
  FilmMasker(FilmMasker&&) noexcept;

  /// The masks of the frames that were learnt from; see FilmSample.
  const std::vector<Image8>& learnt_masks() const;
  const std::vector<int>& learnt_frames() const;

  /// Learns again with log odds for each pixel of each learnt frame, such as other cameras give
  /// them.
  void Listen(std::vector<ImageF> odds);

  /// Frees what was only for learning.
  void EndLearning();

  /// All that looks like the actor in a frame, at working size. Several threads may call it.
  Image8 Regions(int frame, const Image8& rgb) const;

  /// The actor among a frame's regions. Call with ascending frames; one thread at a time.
  Image8 Choose(int frame, const Image8& regions);

  /// Sentences on what a person should look at: other things that move, a set that the film hardly
  /// shows, a camera that changes its exposure.
  std::vector<std::string> Warnings(const std::string& camera) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::capture
