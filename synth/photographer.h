// Turntable photographs of a synthetic world, with exact cameras and masks.
#pragma once

#include <memory>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/progress.h"
#include "synth/photographer_options.h"
#include "synth/world.h"

namespace keypose::synth {

struct SyntheticView {
  View view;     ///< exact camera, in the world's frame (fixed to the character)
  Image8 image;  ///< sRGB photograph
  Image8 mask;   ///< 255 where at least half of the pixel is character
};

/// Takes photographs one by one. Construction prepares light and rays; Take is const and safe from
/// many threads.
class Photographer {
 public:
  /// @param rig  stands where that photographer stands, instead of where the figure fills the
  /// picture; null: on its own
  /// @throws UsageError  bad options
  Photographer(const World& world, const Pose& pose, const PhotographerOptions& options,
               const Photographer* rig = nullptr);
  ~Photographer();
  Photographer(Photographer&&) noexcept;

  int view_count() const;
  /// Named IMG_0001.jpg and so on, ring after ring.
  const View& ViewAt(int i) const;
  /// The i-th photograph; a pure function of world, pose, options and i: same bits for any thread
  /// count.
  SyntheticView Take(int i) const;
  /// The clean plate: the empty set, as seen by every view (the background is static in the
  /// camera's frame).
  Image8 CleanPlate() const;
  const Mesh& surface() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All photographs of one pose.
std::vector<SyntheticView> Photograph(const World& world, const Pose& pose,
                                      const PhotographerOptions& options,
                                      Progress* progress = nullptr);

/// The exact cameras, with `points` truth surface vertices as sparse points, each seen by the views
/// that really see it (for tests of dense, texture).
Scene TruthScene(const World& world, const Pose& pose,
                 const std::vector<SyntheticView>& photographs, int points = 3000);

}  // namespace keypose::synth
