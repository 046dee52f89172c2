// What a film teaches of a fixed camera: at each pixel which colours are the set's and which the
// actor's, and the colours of both at large.
#pragma once

#include <functional>
#include <vector>

#include "capture/films/pixel_modes.h"
#include "capture/segmentation/colour_odds.h"
#include "core/values/image.h"

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

  /// Distance below which colours are the same; see ModeDistance.
  double radius() const { return radius_; }

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
  ImageF prior_;
  Image8 area_;
};

/// Learns from frames spread over the film. First evidence are edges (EdgeEvidence), texture, the
/// network and what a person said; then colours and frames teach each other in rounds: the frames
/// are cut, and each pixel's colours go to the side on which the cuts have them.
/// Same bits for any thread count.
class FilmLearning {
 public:
  /// @param rgb, lab  frames of the film's usual exposure, at least one
  /// @param modes     of these frames
  /// @param area      255 where the actor moves; far from it everything is the set
  FilmLearning(std::vector<Image8> rgb, std::vector<Image8> lab, PixelModes modes, double radius,
               const Image8& area, FilmHints hints, const FilmMaskOptions& options);

  /// Two more rounds with log odds for each pixel of each frame, such as other cameras give them.
  void Listen(std::vector<ImageF> odds);

  const FilmModel& model() const { return model_; }
  const std::vector<Image8>& masks() const { return masks_; }  ///< of the frames
  const FilmHints& hints() const { return hints_; }
  const std::vector<Image8>& rgb() const { return rgb_; }
  const std::vector<Image8>& lab() const { return lab_; }

 private:
  void Begin();
  void AddSalience();
  Image8 FirstTrimap(std::size_t k) const;
  void LearnColours(const std::function<Image8(std::size_t)>& trimap_of);
  void Cut();
  void TakeSides(float limit);
  void TakeTold();
  void FindSet();

  std::vector<Image8> rgb_, lab_;
  PixelModes modes_;
  FilmHints hints_;
  std::vector<ImageF> heard_;
  FilmModel model_;
  std::vector<Image8> masks_;
};

}  // namespace keypose::capture
