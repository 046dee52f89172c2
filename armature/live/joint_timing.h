// Recorded joint curves as the values of each frame of a film.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/options.h"

namespace keypose::armature {

/// One of the ways from one recorded frame to the next.
enum class Between {
  kHold,    ///< the frame stands until the next one: on ones, twos, threes; hard stops
  kLinear,  ///< at even pace
  kSmooth   ///< a smooth curve that goes through all frames and beyond none
};

/// "hold", "linear" or "smooth", as `bake` takes them. @throws UsageError  another word
Between BetweenNamed(const std::string& name);

/// Values of each frame of the film.
///
/// @param recorded  recorded frames x joints, at least one
/// @param step      frames of the film from one recorded frame to the next, >= 1
/// @return  kHold: step rows for each recorded frame; else the last one ends the film
/// Source of kSmooth: Fritsch & Butland, 1984: monotone cubic pieces; where a joint stands still it
/// stays still.
Eigen::MatrixXd FilmValues(const Eigen::MatrixXd& recorded, int step, Between between);

/// Recorded frames one after another that are one pose.
struct PoseRun {
  int first = 0, count = 1;
};

/// The poses of a recording, as keys for other in-betweens: a puppet that rests for several frames
/// is one key that stands.
/// @param recorded  recorded frames x joints, at least one; equal to the last bit is one pose
std::vector<PoseRun> PoseRuns(const Eigen::MatrixXd& recorded);

/// Each joint's curve under a Gaussian of that width. A joint that stands still for two frames or
/// more is a stop: its value there stays, and what comes before and after is not mixed across it.
/// @param sigma  in recorded frames, > 0
Eigen::MatrixXd Smoothed(const Eigen::MatrixXd& recorded, double sigma);

}  // namespace keypose::armature
