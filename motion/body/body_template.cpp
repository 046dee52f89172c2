#include "motion/body/body_template.h"

#include <cmath>
#include <set>

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

// Functions, because the template can be asked for before this file's own constants are made.
Vector3d AxisX() { return Vector3d::UnitX(); }
Vector3d AxisY() { return Vector3d::UnitY(); }
Vector3d AxisZ() { return Vector3d::UnitZ(); }

JointModel Ball(std::string name, int parent, int dof, double share = 1) {
  JointModel joint;
  joint.name = std::move(name);
  joint.parent = parent;
  joint.first_dof = dof;
  joint.ball = true;
  joint.share = share;
  return joint;
}

JointModel Hinges(std::string name, int parent, int dof, std::vector<Vector3d> axes) {
  JointModel joint;
  joint.name = std::move(name);
  joint.parent = parent;
  joint.first_dof = dof;
  joint.hinges = std::move(axes);
  return joint;
}

// side: +1 left, -1 right
void AddArm(std::array<JointModel, kJoints>& joints, int clavicle, int dof, double side) {
  const std::string prefix = side > 0 ? "Left" : "Right";
  joints[clavicle] = Hinges(prefix + "Collar", kChest, dof, {-side * AxisY()});
  joints[clavicle].offset = {{kClavicleHeight, AxisZ()}, {kShoulderBack, AxisY()}};
  joints[clavicle + 1] = Ball(prefix + "Shoulder", clavicle, dof + 1);
  joints[clavicle + 1].offset = {{OnSide(kClavicleWidth, side), side * AxisX()}};
  joints[clavicle + 2] = Hinges(prefix + "Elbow", clavicle + 1, dof + 4, {-side * AxisZ()});
  joints[clavicle + 2].offset = {{OnSide(kUpperArm, side), side * AxisX()}};
  joints[clavicle + 3] =
      Hinges(prefix + "Wrist", clavicle + 2, dof + 5, {side * AxisY(), -side * AxisZ()});
  joints[clavicle + 3].offset = {{OnSide(kForearm, side), side * AxisX()}};
}

void AddLeg(std::array<JointModel, kJoints>& joints, int hip, int dof, double side) {
  const std::string prefix = side > 0 ? "Left" : "Right";
  joints[hip] = Ball(prefix + "Hip", kPelvis, dof);
  joints[hip].offset = {{OnSide(kHipWidth, side), side * AxisX()}};
  joints[hip + 1] = Hinges(prefix + "Knee", hip, dof + 3, {AxisX()});
  joints[hip + 1].offset = {{OnSide(kThigh, side), -AxisZ()}};
  joints[hip + 2] = Hinges(prefix + "Ankle", hip + 1, dof + 4, {AxisX(), side * AxisZ()});
  joints[hip + 2].offset = {{OnSide(kShin, side), -AxisZ()}};
}

std::array<JointModel, kJoints> MakeJoints() {
  std::array<JointModel, kJoints> joints;
  joints[kPelvis] = Ball("Hips", -1, 3);
  joints[kWaist] = Ball("Spine", kPelvis, 6, 0.5);
  joints[kWaist].offset = {{kToWaist, AxisZ()}};
  joints[kChest] = Ball("Chest", kWaist, 6, 0.5);
  joints[kChest].offset = {{kToChest, AxisZ()}};
  joints[kNeck] = Ball("Neck", kChest, 9);
  joints[kNeck].offset = {{kToNeck, AxisZ()}, {kNeckBack, AxisY()}};
  AddArm(joints, kClavicleL, 12, 1);
  AddArm(joints, kClavicleR, 19, -1);
  AddLeg(joints, kHipL, 26, 1);
  AddLeg(joints, kHipR, 32, -1);
  return joints;
}

std::array<SegmentModel, kSegments> MakeSegments() {
  std::array<SegmentModel, kSegments> segments{{
      {"pelvis", kPelvis, kToWaist, Vector3d::Zero(), AxisZ(), AxisX(), 0.13, 0.06},
      {"abdomen", kWaist, kToChest, Vector3d::Zero(), AxisZ(), AxisX(), 0.06, 0.06},
      {"chest", kChest, kToNeck, Vector3d::Zero(), AxisZ(), AxisX(), 0.06, 0.04},
      {"head", kNeck, kHeadLength, Vector3d::Zero(), AxisZ(), AxisX(), 0.05, 0.0},
  }};
  int next = 4;
  for (const double side : {1.0, -1.0}) {
    const std::string prefix = side > 0 ? "left_" : "right_";
    const int shoulder = side > 0 ? kShoulderL : kShoulderR;
    const Vector3d out = side * AxisX();
    segments[next++] = {prefix + "upper_arm",
                        shoulder,
                        OnSide(kUpperArm, side),
                        Vector3d::Zero(),
                        out,
                        AxisY(),
                        0.07,
                        0.035};
    segments[next++] = {prefix + "forearm",
                        shoulder + 1,
                        OnSide(kForearm, side),
                        Vector3d::Zero(),
                        out,
                        AxisY(),
                        0.04,
                        0.02};
    segments[next++] = {prefix + "hand",
                        shoulder + 2,
                        OnSide(kHand, side),
                        Vector3d::Zero(),
                        out,
                        AxisY(),
                        0.02,
                        0.0};
  }
  for (const double side : {1.0, -1.0}) {
    const std::string prefix = side > 0 ? "left_" : "right_";
    const int hip = side > 0 ? kHipL : kHipR;
    segments[next++] = {prefix + "thigh",
                        hip,
                        OnSide(kThigh, side),
                        Vector3d::Zero(),
                        -AxisZ(),
                        AxisX(),
                        0.09,
                        0.045};
    segments[next++] = {prefix + "shin",
                        hip + 1,
                        OnSide(kShin, side),
                        Vector3d::Zero(),
                        -AxisZ(),
                        AxisX(),
                        0.05,
                        0.03};
    segments[next++] = {prefix + "foot",
                        hip + 2,
                        OnSide(kFoot, side),
                        Vector3d(0, 0.07, -0.045),
                        -AxisY(),
                        AxisX(),
                        0.0,
                        0.0};
  }
  return segments;
}

struct TrunkDof {
  const char* name;
  double low, high;
};
constexpr TrunkDof kTrunkDofs[] = {{"spine_bend", -0.6, 1.6},  {"spine_lean", -0.8, 0.8},
                                   {"spine_twist", -0.9, 0.9}, {"head_nod", -0.9, 1.0},
                                   {"head_lean", -0.7, 0.7},   {"head_turn", -1.2, 1.2}};

std::array<DofModel, kDofs> MakeDofs() {
  std::array<DofModel, kDofs> dofs;
  int at = 0;
  const auto add = [&](const std::string& name, double low, double high) {
    dofs[at++] = {name, low, high};
  };
  for (const char* axis : {"x", "y", "z"}) add(std::string("root_") + axis, 0, 0);
  for (const char* axis : {"x", "y", "z"}) add(std::string("root_turn_") + axis, 0, 0);
  for (const TrunkDof& dof : kTrunkDofs) add(dof.name, dof.low, dof.high);
  for (const double side : {1.0, -1.0}) {
    const std::string p = side > 0 ? "left_" : "right_";
    // A range of the left side, mirrored for the right one where the axis keeps its direction.
    const auto mirrored = [&](const std::string& name, double low, double high) {
      side > 0 ? add(p + name, low, high) : add(p + name, -high, -low);
    };
    add(p + "collar", -0.15, 0.7);
    add(p + "shoulder_twist", -1.9, 1.9);
    mirrored("shoulder_lower", -1.7, 1.9);
    mirrored("shoulder_back", -2.3, 1.2);
    add(p + "elbow", 0.0, 2.6);
    add(p + "wrist_bend", -1.3, 1.3);
    add(p + "wrist_turn", -0.6, 0.6);
  }
  for (const double side : {1.0, -1.0}) {
    const std::string p = side > 0 ? "left_" : "right_";
    const auto mirrored = [&](const std::string& name, double low, double high) {
      side > 0 ? add(p + name, low, high) : add(p + name, -high, -low);
    };
    add(p + "hip_back", -2.4, 0.8);
    mirrored("hip_in", -1.3, 0.6);
    mirrored("hip_twist", -0.9, 0.9);
    add(p + "knee", 0.0, 2.6);
    add(p + "ankle_point", -0.6, 1.0);
    add(p + "ankle_turn", -0.5, 0.5);
  }
  return dofs;
}

// An ellipse with half axes a (along the segment's side) and b, nearly.
void SetEllipses(Eigen::Matrix<double, kStations, kHarmonics>& radii,
                 const std::array<double, kStations>& a, const std::array<double, kStations>& b) {
  radii.setZero();
  for (int k = 0; k < kStations; ++k) {
    radii(k, 0) = (a[k] + b[k]) / 2;
    radii(k, 3) = (a[k] - b[k]) / 2;
  }
}

void SetLimbs(BodyShape& shape) {
  for (int side = 0; side < 2; ++side) {
    const int arm = 4 + 3 * side, leg = 10 + 3 * side;
    SetEllipses(shape.radii[arm], {.058, .058, .054, .050, .047, .045, .044},
                {.062, .060, .055, .050, .047, .045, .043});
    SetEllipses(shape.radii[arm + 1], {.044, .044, .043, .040, .036, .032, .030},
                {.043, .043, .041, .037, .033, .029, .026});
    SetEllipses(shape.radii[arm + 2], {.034, .038, .042, .043, .040, .036, .030},
                {.022, .022, .022, .020, .018, .016, .014});
    SetEllipses(shape.radii[leg], {.088, .090, .086, .079, .070, .062, .058},
                {.090, .093, .088, .080, .071, .063, .058});
    SetEllipses(shape.radii[leg + 1], {.055, .057, .058, .054, .046, .040, .039},
                {.056, .060, .061, .056, .047, .041, .042});
    SetEllipses(shape.radii[leg + 2], {.032, .036, .040, .043, .045, .044, .036},
                {.042, .048, .050, .042, .032, .024, .018});
  }
}

}  // namespace

const std::array<JointModel, kJoints>& Joints() {
  static const std::array<JointModel, kJoints> joints = MakeJoints();
  return joints;
}

const std::array<SegmentModel, kSegments>& Segments() {
  static const std::array<SegmentModel, kSegments> segments = MakeSegments();
  return segments;
}

const std::array<DofModel, kDofs>& Dofs() {
  static const std::array<DofModel, kDofs> dofs = MakeDofs();
  return dofs;
}

const std::vector<int>& ChainOf(int joint) {
  static const std::array<std::vector<int>, kJoints> chains = [] {
    std::array<std::vector<int>, kJoints> all;
    for (int j = 0; j < kJoints; ++j) {
      if (const int parent = Joints()[j].parent; parent >= 0) all[j] = all[parent];
      all[j].push_back(j);
    }
    return all;
  }();
  return chains[joint];
}

const std::vector<int>& DofsThatMove(int joint) {
  static const std::array<std::vector<int>, kJoints> dofs = [] {
    std::array<std::vector<int>, kJoints> all;
    for (int j = 0; j < kJoints; ++j) {
      std::set<int> moving{0, 1, 2};
      for (const int above : ChainOf(j)) {
        const JointModel& turning = Joints()[above];
        const int count = turning.ball ? 3 : static_cast<int>(turning.hinges.size());
        for (int k = 0; k < count; ++k) moving.insert(turning.first_dof + k);
      }
      all[j].assign(moving.begin(), moving.end());
    }
    return all;
  }();
  return dofs[joint];
}

int SegmentOn(int joint) {
  for (int s = 0; s < kSegments; ++s)
    if (Segments()[s].joint == joint) return s;
  return -1;
}

double BodyShape::height() const {
  const auto& l = lengths;
  // the sole lies below the ankle by the foot's half thickness and its axis
  return l[kToWaist] + l[kToChest] + l[kToNeck] + l[kHeadLength] + l[kThigh] + l[kShin] + 0.12;
}

BodyShape AverageShape(double height_m) {
  BodyShape shape;
  shape.lengths << .11, .16, .27, .26, .21, .01, .01, .17, .28, .25, .19, .09, .42, .41, .25, .17,
      .28, .25, .19, .09, .42, .41, .25;
  SetEllipses(shape.radii[0], {.150, .165, .172, .172, .165, .155, .150},
              {.105, .112, .118, .118, .112, .106, .102});
  SetEllipses(shape.radii[1], {.152, .148, .145, .143, .145, .150, .155},
              {.104, .102, .100, .100, .102, .105, .108});
  SetEllipses(shape.radii[2], {.150, .156, .163, .170, .172, .160, .120},
              {.108, .112, .116, .118, .115, .105, .080});
  SetEllipses(shape.radii[3], {.065, .056, .060, .074, .078, .078, .070},
              {.065, .060, .074, .092, .098, .096, .082});
  SetLimbs(shape);
  return Scaled(shape, height_m / 1.75);
}

BodyShape Scaled(const BodyShape& shape, double factor) {
  BodyShape scaled = shape;
  scaled.lengths *= factor;
  for (auto& radii : scaled.radii) radii *= factor;
  return scaled;
}

}  // namespace keypose::motion
