// Turntable photographs of a synthetic world, with exact cameras and masks.
#pragma once

#include <memory>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/progress.h"
#include "synth/photographs/photographer_options.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

struct SyntheticView {
  View view;     ///< exact camera, in the world's frame (fixed to the character)
  Image8 image;  ///< sRGB photograph
  Image8 mask;   ///< 255 where the character covers at least half of the pixel
};

/// Takes photographs one by one. The constructor prepares light and rays; Take is const and
/// thread-safe.
class Photographer {
 public:
  /// @param rig  a photographer whose camera positions are used; null: positions so that the figure
  /// fills the picture
  /// @throws UsageError  bad options
  Photographer(const World& world, const Pose& pose, const PhotographerOptions& options,
               const Photographer* rig = nullptr);
  ~Photographer();
  Photographer(Photographer&&) noexcept;

  int view_count() const;
  /// Named IMG_0001.jpg, IMG_0002.jpg, ..., ring after ring.
  const View& ViewAt(int i) const;
  /// The i-th photograph; a pure function of world, pose, options and i: same bits for any thread
  /// count.
  SyntheticView Take(int i) const;
  /// The clean plate: the set without the figure, the same for every view (the background is static
  /// in the camera's frame).
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

/// The exact cameras, with `points` vertices of the true surface as sparse points, each with the
/// views that really see it (for tests of dense and texture).
Scene TruthScene(const World& world, const Pose& pose,
                 const std::vector<SyntheticView>& photographs, int points = 3000);

}  // namespace keypose::synth
