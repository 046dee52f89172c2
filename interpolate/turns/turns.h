// In which direction, and how many times, each face turns between two keys.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// A limb that must turn further than its neighbours suggest, or in the other direction.
struct TurnOverride {
  std::string name;
  /// The limb's faces. One face stands for the rigid cluster around it (neighbours whose rotations
  /// differ by less than 10 degrees).
  std::vector<int> faces;
  /// whole turns about the limb's own axis, right-handed, from the first key to the second
  int extra_turns = 0;
  /// In the first key's space; zero: the limb's mean rotation vector relative to the body.
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
};

/// Measurements of the turns.
struct TurnReport {
  double largest_turn = 0;       ///< of any face relative to the body [rad]
  double largest_remainder = 0;  ///< of any face [rad]
  int far_faces = 0;             ///< with remainders over 1.5 rad
  /// neighbouring faces whose turns differ half-way by over 0.5 rad more than at the ends
  int torn_edges = 0;
  /// torn edges whose two faces agree at both ends: a ring turned inside itself
  int loops_that_do_not_close = 0;
  /// Limbs that turn by half a turn, within 3 degrees, relative to the faces next to them, in one
  /// step from face to face: the keys do not determine the direction.
  std::vector<std::vector<int>> half_turns;
  /// no consistent rotation vectors: relative rotations are integrated for each frame
  bool differential = false;
};

/// Makes neighbouring faces of a pair of keys turn the same way; fills turn, remainder and
/// body_turn of `maps`.
///
/// The body is the largest rigid cluster. Its mean rotation becomes body_turn, and all other turns
/// are relative to it, so that shapes hardly depend on the keys' relative orientation. A tree over
/// neighbouring faces grows from the body, smallest difference first. A face's candidates are its
/// rotation vector plus whole turns about its axis; it takes the candidate nearest to its parent's
/// turn. Beyond 200 degrees the axis of a rotation becomes uncertain, and at 360 degrees it is
/// undefined. There a face starts from its parent's vector and takes one Newton step to its own
/// rotation, damped across the axis, so that the angle is exact for any number of turns.
///
/// The rotation vectors are smoothed over the surface (by `system`'s screened solve), which gives
/// every face a smooth axis. The face's rotation is then split into a turn about that axis, with
/// the winding found before, and a remainder across it: rotation(t) = exp(t body) exp(t turn) exp(t
/// remainder). If, even without smoothing, over 0.5 % of faces have remainders over 1.5 rad, or
/// over 1 % of edges tear, no rotation vectors are consistent, and `differential` is set.
/// Deterministic.
/// Source: after Gao et al., as-consistent-as-possible axis-angle, TVCG 2019, by a tree in place of
/// a global solve; the split into twist and swing about a smooth axis is our own.
/// @param axes_in_second_key  the overrides' axes are given in the space of the maps' second key,
/// for turns towards the first
/// @throws InputError  an override with a face that does not exist, no face, or no axis; names it
TurnReport FollowTurns(const PoissonSystem& system, SegmentMaps& maps,
                       const std::vector<TurnOverride>& overrides = {},
                       bool axes_in_second_key = false);

/// Faces in an order in which each comes after the neighbour from which it takes its turn: smallest
/// difference of rotations first.
struct FaceTree {
  struct Step {
    int face, parent;  ///< parent == face at a root
  };
  std::vector<Step> steps;
};
/// @param rotations   of faces; `loose` faces (no rotation of their own) come last
/// @param first_roots start first, in order; parts that they do not reach start from their lowest
/// face
FaceTree GrowTree(const std::vector<std::array<int, 3>>& neighbours,
                  const std::vector<Eigen::Quaterniond>& rotations, const std::vector<char>& loose,
                  const std::vector<int>& first_roots);

/// Faces across the sides 01, 12, 20 of each face; -1 where there is none. Sides with more than two
/// faces are paired in order.
std::vector<std::array<int, 3>> FaceNeighbours(int vertex_count, const FacesX3& faces);

}  // namespace keypose::interpolation
