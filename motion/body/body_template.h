// The kinematic template: a skeleton of 18 joints with 38 degrees of freedom, and sixteen closed
// surface segments on it.
//
// In the rest pose it stands upright (z up), faces -y, and holds its arms along x, the left one
// towards +x. All joints' frames are then parallel to the world's. Metres, radians.
// Source: Carranza, Theobalt, Magnor & Seidel, "Free-viewpoint video of human actors", SIGGRAPH
// 2003, section 4, for the number of segments and the fit to silhouettes. Departs: the segments are
// generated here, from radii.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace keypose::motion {

inline constexpr int kJoints = 18;
inline constexpr int kSegments = 16;
inline constexpr int kDofs = 38;
inline constexpr int kLengths = 23;
inline constexpr int kStations = 7;   ///< of radii along a segment
inline constexpr int kHarmonics = 7;  ///< of radii around a segment: 1, cos, sin, ... of 3 angles

/// Joints by index; parents come first.
enum JointIndex : int {
  kPelvis,
  kWaist,
  kChest,
  kNeck,
  kClavicleL,
  kShoulderL,
  kElbowL,
  kWristL,
  kClavicleR,
  kShoulderR,
  kElbowR,
  kWristR,
  kHipL,
  kKneeL,
  kAnkleL,
  kHipR,
  kKneeR,
  kAnkleR
};

/// Bone lengths [m]. Those of the right side stand kRight places after those of the left.
enum LengthIndex : int {
  kToWaist,
  kToChest,
  kToNeck,
  kHeadLength,
  kClavicleHeight,
  kShoulderBack,
  kNeckBack,  ///< of the shoulders and the neck behind the chest's joint
  kClavicleWidth,
  kUpperArm,
  kForearm,
  kHand,
  kHipWidth,
  kThigh,
  kShin,
  kFoot
};
inline constexpr int kRight = 8;
/// The length of the same bone on the left (side > 0) or on the right.
inline LengthIndex OnSide(LengthIndex left, double side) {
  return static_cast<LengthIndex>(left + (side > 0 ? 0 : kRight));
}

/// How a joint turns.
struct JointModel {
  std::string name;  ///< as BVH files name it
  int parent = -1;
  int first_dof = 0;  ///< of its rotation
  bool ball = false;  ///< an exponential map of three numbers, else hinges in turn
  double share = 1;   ///< of the exponential map: the spine's turn is shared by two joints
  std::vector<Eigen::Vector3d> hinges;  ///< axes
  /// offset from the parent's joint: sum of length * direction
  std::vector<std::pair<LengthIndex, Eigen::Vector3d>> offset;
};

/// Where a segment's surface lies in its joint's frame: along `axis` from -behind to its length
/// + beyond, with radii measured from `side` around the axis.
struct SegmentModel {
  std::string name;
  int joint = 0;
  LengthIndex length = kToWaist;
  Eigen::Vector3d origin, axis, side;
  double behind = 0, beyond = 0;  ///< [m] for a body of 1.75 m; they do not change with the shape
};

struct DofModel {
  std::string name;          ///< such as "left_elbow"
  double low = 0, high = 0;  ///< limits [rad]; equal: none
};

const std::array<JointModel, kJoints>& Joints();
const std::array<SegmentModel, kSegments>& Segments();
const std::array<DofModel, kDofs>& Dofs();
/// The joint and all before it up to the root, root first.
const std::vector<int>& ChainOf(int joint);
/// Numbers of the pose that move what is fixed to the joint, in rising order.
const std::vector<int>& DofsThatMove(int joint);
/// The segment on a joint, or -1.
int SegmentOn(int joint);

/// Bone lengths and girths of one actor.
struct BodyShape {
  Eigen::Matrix<double, kLengths, 1> lengths;  ///< [m]
  /// [m] for each segment, stations from its start to its end by harmonics
  std::array<Eigen::Matrix<double, kStations, kHarmonics>, kSegments> radii;
  double height() const;  ///< [m] from the soles to the crown, standing
};
/// A person of average proportions.
/// @param height_m  from the soles to the crown
BodyShape AverageShape(double height_m = 1.75);
/// All sizes times a factor.
BodyShape Scaled(const BodyShape& shape, double factor);

}  // namespace keypose::motion
