// An armature with a sensor on each joint, its pose from its joints' values, and the chains by
// which a computer skeleton follows it.
//
// A description file (docs/file-formats.md) becomes an `Armature`, the second file a `ChainPlan`.
// Source: Knep, Hayes, Sayre & Williams, "Dinosaur Input Device", CHI 1995, Figures 2 and 3.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose::armature {

/// What a node does to the frame that its children stand in.
enum class NodeKind {
  kGroup,  ///< nothing; it only gathers and names
  kJoint,  ///< turns about an axis: a hinge or a swivel
  kSlide,  ///< moves along an axis: a carriage of the rig that holds the armature
  kRod     ///< leads along an axis by a fixed length
};

struct ArmatureNode {
  std::string name;
  int parent = -1;  ///< index of an earlier node; -1: at the top of the file
  NodeKind kind = NodeKind::kGroup;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit; in the parent's frame
  int sensor = -1;                                  ///< of joints and slides, >= 0 and unique
  /// Encoder revolutions for one revolution of the joint, or for one unit of length [1/m] of a
  /// slide; signed, never 0. The sense that the file was written in is already undone.
  double scale = 1;
  double length = 0;  ///< of a rod, >= 0 [m; the file's own unit if it names none]
  /// Where the joint's stops are, low <= high [rad; of a slide as `length`]; none: infinite.
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  int line = 0;  ///< of the file, from 1; for messages
  bool moves() const { return kind == NodeKind::kJoint || kind == NodeKind::kSlide; }
};

/// In file order: each node is followed by all below it. In the zero position all frames are
/// parallel to the world's.
struct Armature {
  std::vector<ArmatureNode> nodes;
  std::vector<int> joints;              ///< the nodes that move, joints and slides, in file order
  double counts_per_revolution = 1024;  ///< of an encoder, all edges counted
  double metres_per_unit = 0;           ///< of the file's lengths; 0: it names no unit

  /// The node of that name, or -1.
  int Find(const std::string& name) const;
  /// Place of a node in `joints`, or -1.
  int JointOf(int node) const;
  /// Place in `joints` of the one that this sensor watches, or -1.
  int JointOfSensor(int sensor) const;
  int sensor_count() const;  ///< one more than the largest sensor index
};

/// World frames of all nodes: x_in_world = result[n] * x_in_node. The frame of a joint stands at
/// its centre and has turned; that of a rod stands at its far end.
/// @param values  one for each of `armature.joints`, from the zero position: [rad] of a joint, [m]
///                of a slide
/// @pre values.size() == armature.joints.size()
std::vector<Rigid3> ForwardKinematics(const Armature& armature, const std::vector<double>& values);
/// The same into `frames`, without new memory after the first call.
void ForwardKinematics(const Armature& armature, const std::vector<double>& values,
                       std::vector<Rigid3>* frames);

/// Nodes from one to another along the tree, both included.
/// @return empty if they stand in different trees
std::vector<int> PathBetween(const Armature& armature, int from, int to);

/// A place that both skeletons share: matched as exactly as possible.
struct Anchor {
  std::string name;
  int node = -1;         ///< of the armature
  std::string computer;  ///< joint of the computer skeleton
  int line = 0;
};

/// kExact: joint on joint, one to one, as the paper's legs; kMatch: the computer's joints are laid
/// along the armature's curve.
enum class ChainMode { kMatch, kExact };

struct Chain {
  std::string name;
  int from = -1, to = -1;             ///< anchors; `from` is the one that is matched exactly
  std::vector<int> nodes;             ///< of the armature, from the first anchor's to the second's
  std::vector<std::string> computer;  ///< joints between the anchors' joints, in order; empty: all
                                      ///< that stand between them in the computer skeleton
  ChainMode mode = ChainMode::kMatch;
  int line = 0;
};

/// Chains come in an order in which the near anchor of each is the far anchor of an earlier one,
/// or of none. No two chains share a far anchor.
struct ChainPlan {
  std::vector<Anchor> anchors;
  std::vector<Chain> chains;
  /// The anchor of that name, or -1.
  int FindAnchor(const std::string& name) const;
};

/// For each of `armature.joints` the chains whose curve it moves: those that hang below it, wholly
/// or in part. A chain of which no such joint has changed needs no new matching.
std::vector<std::vector<int>> ChainsMovedBy(const Armature& armature, const ChainPlan& plan);

}  // namespace keypose::armature
