// What a film teaches of a fixed camera: at each pixel which colours are the set's and which the
// actor's, and the colours of both at large.
#pragma once

#include <vector>

#include "capture/films/pixel_modes.h"
#include "capture/segmentation/colour_odds.h"
#include "core/image.h"

namespace keypose::capture {

struct FilmMaskOptions {
  double smoothness = 12;  ///< cost of a border between two pixels of the same colour, in log odds
  double odds_limit = 6;   ///< largest weight of one pixel, in log odds
  int rounds = 3;          ///< segmentations of the frames that are learnt from, >= 1
};

/// What is known beforehand of the frames that are learnt from; each list is empty, or has one
/// entry per frame, empty where nothing is known of it.
struct FilmHints {
  std::vector<Image8> salience;  ///< the network's opinion, see SalienceNetwork::Of
  std::vector<Image8> told;      ///< what a person said: trimaps (capture/segmentation/trimap.h)
};

class FilmModel {
 public:
  /// Log odds of actor against set at each pixel of one frame.
  /// @param rgb, lab  the frame, of the film's usual exposure and of the model's size
  ImageF Odds(const Image8& rgb, const Image8& lab) const;

  /// All regions that look like the actor, holes filled unless they show the set.
  Image8 Regions(const Image8& rgb, const ImageF& odds) const;

  /// Share of the area of motion where the film shows the set, in [0, 1].
  double set_known() const;

 private:
  friend class FilmLearning;
  float ModeOdds(std::size_t pixel, const std::uint8_t* lab) const;

  FilmMaskOptions options_;
  double radius_ = 6;
  PixelModes modes_;              // without labels
  std::vector<float> mode_odds_;  // kMostModes for each pixel
  std::vector<std::int8_t>
      set_;  // the pixel's mode that is the set's; -1: the film does not show it
  ColorOdds colours_;
  bool colours_known_ = false;
  ImageF prior_;
  Image8 area_;
};

struct LearntFilm {
  FilmModel model;
  std::vector<Image8> masks;  ///< of the frames that were learnt from
};

/// Learns from frames spread over the film. First evidence are edges (EdgeEvidence), the network
/// and what a person said; then colours and frames teach each other in rounds: the frames are cut,
/// and each pixel's colours go to the side on which the cuts have them.
///
/// @param rgb, lab  frames of the film's usual exposure, at least one
/// @param modes     of these frames
/// @param area      255 where the actor moves; far from it everything is the set
/// Same bits for any thread count.
LearntFilm LearnFilm(const std::vector<Image8>& rgb, const std::vector<Image8>& lab,
                     const PixelModes& modes, double radius, const Image8& area,
                     const FilmHints& hints, const FilmMaskOptions& options);

}  // namespace keypose::capture
