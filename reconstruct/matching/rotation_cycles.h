// Pairs whose rotation the others contradict.
//
// What repeats itself (a printed mat, tiles, the fingers of a row of puppets) lets photographs
// match at a wrong turn, with many matches that agree with each other. Round a loop of three
// photographs the turns must cancel; one rotation for each photograph is found that most pairs
// agree with, and pairs that do not are left out.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/values/camera.h"
#include "reconstruct/matching/verification.h"

namespace keypose::reconstruct {

struct RotationCycleOptions {
  double loop_deg = 8;    ///< a loop of three closes to so much
  double apart_deg = 10;  ///< a pair agrees with its photographs' rotations to so much
  int trees = 120;        ///< of pairs, at random, that rotations are found along
  int rounds = 40;        ///< of averaging
};

/// A pair's relative rotation: x_second = rotation * x_first + translation.
struct PairRotation {
  int first = 0, second = 0;
  Eigen::Quaterniond rotation;
  int matches = 0;
  bool flat = false;  ///< the pair shares only a plane, which may repeat itself
};

/// Nothing where the matches determine none.
std::optional<PairRotation> RotationOf(const Features& first, const Features& second,
                                       const Camera& camera_first, const Camera& camera_second,
                                       const PairMatches& pair, double max_error_px);

/// Which pairs agree with the rotations that most agree with. Flat pairs do not count, and do not
/// agree, where others connect their photographs.
/// Same result for any thread count.
/// Source: Govindu, "Robustness in motion averaging", ACCV 2006 (random trees), and Hartley et al.,
/// "Rotation averaging", IJCV 2013 (averages in the tangent space).
std::vector<char> AgreeInRotation(int images, const std::vector<PairRotation>& pairs,
                                  const RotationCycleOptions& options);

/// Erases pairs that the others contradict, and flat ones that are not needed.
/// @param lens  of each image
/// @param flat  of each pair; see FlatPairs
/// @return number of erased pairs
int LeaveOutContradictedTurns(const std::vector<Features>& features,
                              const std::vector<Camera>& lens, const std::vector<char>& flat,
                              double max_error_px, const RotationCycleOptions& options,
                              std::vector<Verified>& verified);

}  // namespace keypose::reconstruct
