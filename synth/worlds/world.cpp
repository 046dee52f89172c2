#include "synth/worlds/world.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "synth/worlds/columns.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/outer_surface.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr double kFistRadius = 0.0140, kThumbRadius = 0.0050;  // [m] of the right hand
const Vector3d kEarRoot(0.034, 0.0, 0.172);                    // [m]
const Vector3d kThumb(0.010, -0.010, 0.0090);                  // [m] from the middle of the fist

/// Linear light from an sRGB colour, 0..255.
Vector3d Srgb(int r, int g, int b) {
  return {LinearFromSrgb(r / 255.0), LinearFromSrgb(g / 255.0), LinearFromSrgb(b / 255.0)};
}

Vector3d Between(const Vector3d& a, const Vector3d& b, double share) { return a + share * (b - a); }

struct Palette {
  Vector3d body, belly, limb, hand, scarf, horn, spot, spike;
};

const Palette kPalettes[] = {
    {Srgb(72, 158, 150), Srgb(226, 204, 150), Srgb(82, 146, 166), Srgb(236, 176, 70),
     Srgb(206, 74, 62), Srgb(240, 224, 190), Srgb(42, 104, 116), Srgb(228, 128, 62)},
    {Srgb(204, 112, 76), Srgb(238, 206, 160), Srgb(190, 96, 80), Srgb(120, 148, 88),
     Srgb(70, 110, 168), Srgb(244, 232, 206), Srgb(140, 62, 52), Srgb(236, 190, 84)},
    {Srgb(150, 176, 84), Srgb(236, 226, 166), Srgb(118, 156, 82), Srgb(214, 108, 120),
     Srgb(112, 82, 150), Srgb(236, 216, 180), Srgb(86, 118, 58), Srgb(222, 150, 70)},
    {Srgb(158, 132, 186), Srgb(236, 214, 206), Srgb(138, 112, 170), Srgb(238, 196, 92),
     Srgb(84, 150, 130), Srgb(244, 230, 200), Srgb(104, 74, 140), Srgb(222, 110, 98)},
};

// Builds the creature part by part and records the named places.
class Sculptor {
 public:
  explicit Sculptor(std::uint64_t seed) : random_(seed), spread_(seed == 1 ? 0 : 1) {
    palette_ = kPalettes[seed == 1 ? 0 : random_.Below(4)];
    clay_.seed = static_cast<std::uint32_t>(Hash(seed) & 0xffffff);
  }

  void Sculpt() {
    Body();
    Head();
    Ears();
    Arms();
    Tail();
    Spots();
  }

  const Clay& clay() const { return clay_; }
  const std::vector<std::pair<std::string, Vector3d>>& places() const { return places_; }
  const std::vector<PosableLimb>& limbs() const { return limbs_; }
  std::vector<Pose> Poses() const;

 private:
  double Vary(double value, double share) {
    return value * (1 + spread_ * random_.Uniform(-share, share));
  }
  Vector3d Vary(const Vector3d& p, double by_m) {
    return p + spread_ * by_m *
                   Vector3d(random_.Uniform(-1, 1), random_.Uniform(-1, 1), random_.Uniform(-1, 1));
  }
  void Add(const Vector3d& a, double ra, const Vector3d& b, double rb, const Vector3d& color,
           double blend = 0.006, bool crisp = false) {
    clay_.lumps.push_back({a, b, ra, rb, blend, color, crisp});
  }
  void Ball(const Vector3d& c, double r, const Vector3d& color, double blend = 0.004,
            bool crisp = false) {
    Add(c, r, c, r, color, blend, crisp);
  }
  void Name(const char* name, const Vector3d& place) { places_.emplace_back(name, place); }

  Pose HipPose(double turn_degrees, double bend_degrees) const;
  Pose HandOnHip() const;
  void Body();
  void Head();
  void Ears();
  void Arms();
  void LeftArm();
  void RightArm();
  void Tail();
  void Spots();

  Random random_;
  double spread_;  // 0: the proportions of the demo
  Palette palette_;
  Clay clay_;
  std::vector<std::pair<std::string, Vector3d>> places_;
  std::vector<PosableLimb> limbs_;
  Clay trunk_, thighs_;  // the hand rests on the trunk and keeps clear of the thighs
  Vector3d shoulder_, arm_axis_, elbow_, forearm_axis_, right_shoulder_, fist_;
};

void Sculptor::Body() {
  const double girth = Vary(1, 0.12);
  Add({0, 0, 0.050}, 0.042 * girth, {0.003, 0.001, 0.088}, 0.032 * girth, palette_.body, 0.01);
  Add({-0.002, -0.017 * girth, 0.046}, 0.029 * girth, {0.001, -0.014 * girth, 0.072}, 0.022 * girth,
      palette_.belly, 0.004);
  trunk_.lumps = clay_.lumps;
  const Vector3d left_toe = Vary(Vector3d(0.033, -0.040, 0.011), 0.004),
                 right_toe = Vary(Vector3d(-0.044, -0.033, 0.012), 0.004);
  Add({0.027, -0.002, 0.015}, 0.018, left_toe, 0.0135, palette_.limb, 0.008);
  Add({-0.028, 0.001, 0.016}, 0.020, right_toe, 0.0155, palette_.limb, 0.008);
  thighs_.lumps.assign(clay_.lumps.end() - 2, clay_.lumps.end());
  for (Clay* part : {&trunk_, &thighs_}) {
    part->dent_depth = 0;
    part->flat_base = false;
  }
  Name("left_toe", left_toe + Vector3d(0.002, -0.0132, 0));
  Name("right_toe", right_toe + Vector3d(-0.006, -0.0142, 0));
  // Two buttons, the lower one off centre.
  Ball({0.001, -0.0455 * girth, 0.058}, 0.0052, palette_.spike, 0.001, true);
  Ball({-0.007, -0.0365 * girth, 0.079}, 0.0045, palette_.scarf, 0.001, true);
  Name("button", {0.001, -0.0455 * girth - 0.005, 0.058});
  // Spikes down the back, the third leaning to one side.
  const double heights[4] = {0.150, 0.103, 0.083, 0.062}, backs[4] = {0.024, 0.028, 0.033, 0.039},
               sizes[4] = {0.0075, 0.009, 0.010, 0.009};
  for (int i = 1; i < 4; ++i) {
    const double lean = i == 2 ? 0.006 : -0.001;
    const Vector3d tip(lean, backs[i] * girth + Vary(0.013, 0.2), heights[i] + 0.011);
    Add({0.001, backs[i] * girth - 0.004, heights[i]}, sizes[i], tip, 0.0022, palette_.spike,
        0.003);
    if (i == 2) Name("back_spike", tip + Vector3d(0, 0.002, 0.001));
  }
  // A knotted scarf.
  constexpr int kLinks = 9;
  for (int i = 0; i < kLinks; ++i) {
    const double a = 2 * kPi * i / kLinks, b = 2 * kPi * (i + 1) / kLinks;
    const auto at = [](double t) {
      return Vector3d(0.001 + 0.0245 * std::cos(t), -0.001 + 0.0235 * std::sin(t),
                      0.116 + 0.004 * std::sin(t + 0.6));
    };
    Add(at(a), 0.0088, at(b), 0.0088, palette_.scarf, 0.003);
  }
  Add({0.013, -0.027, 0.110}, 0.0085, {0.018, -0.036, 0.088}, 0.0070, palette_.scarf, 0.003);
  Name("scarf_end", {0.019, -0.043, 0.085});
}

void Sculptor::Head() {
  const double size = Vary(1, 0.08);
  Add({0, 0, 0.105}, 0.021, {0.001, -0.003, 0.135}, 0.021, palette_.body, 0.01);
  Add({-0.012, -0.006, 0.157}, 0.034 * size, {0.015, -0.006, 0.159}, 0.033 * size, palette_.body,
      0.012);
  const Vector3d muzzle = Vary(Vector3d(0.004, -0.050, 0.145), 0.003);
  Add({0.002, -0.030, 0.147}, 0.021, muzzle, 0.0155, palette_.belly, 0.008);
  const Vector3d nose = muzzle + Vector3d(0.001, -0.0135, 0.0075);
  Ball(nose, 0.0075, Srgb(52, 38, 40), 0.002, true);
  Name("nose", nose + Vector3d(0, -0.0075, 0));
  const double left = Vary(0.0105, 0.15), right = Vary(0.0088, 0.15);
  const Vector3d left_eye(0.0195, -0.0335 * size - 0.0005, 0.1735),
      right_eye(-0.0155, -0.0345 * size - 0.0005, 0.1715);
  const Vector3d look = Vector3d(0.18, -1, 0.12).normalized();
  Ball(left_eye, left, Srgb(246, 242, 232), 0.0015, true);
  Ball(right_eye, right, Srgb(246, 242, 232), 0.0015, true);
  Ball(left_eye + (left - 0.0034) * look, 0.0052, Srgb(28, 26, 32), 0.0005, true);
  Ball(right_eye + (right - 0.0030) * look, 0.0046, Srgb(28, 26, 32), 0.0005, true);
  Name("left_eye", left_eye + (left + 0.0018) * look);
  Name("right_eye", right_eye + (right + 0.0016) * look);
  // One raised brow; a smile that rises on one side.
  Add(left_eye + Vector3d(-0.008, 0.002, 0.0125), 0.0034, left_eye + Vector3d(0.009, 0.004, 0.0150),
      0.0028, palette_.spot, 0.002);
  Add(muzzle + Vector3d(-0.010, -0.0085, -0.0075), 0.0022,
      muzzle + Vector3d(0.002, -0.0125, -0.0092), 0.0024, palette_.scarf, 0.001);
  Add(muzzle + Vector3d(0.002, -0.0125, -0.0092), 0.0024,
      muzzle + Vector3d(0.0135, -0.0060, -0.0030), 0.0020, palette_.scarf, 0.001);
  // A tuft on the crown, off centre.
  Add({-0.006, 0.002, 0.188}, 0.0085, {-0.012, 0.012, 0.203}, 0.0035, palette_.spike, 0.004);
  Name("tuft", {-0.0125, 0.0135, 0.2060});
}

void Sculptor::Ears() {
  // A long ear that folds over on the left, a stub of a horn on the right.
  const Vector3d fold = Vary(Vector3d(0.056, 0.004, 0.196), 0.004),
                 tip = fold + Vector3d(0.019, -0.004, Vary(-0.016, 0.3));
  Add(kEarRoot, 0.0125, fold, 0.0100, palette_.limb, 0.008);
  Add(fold, 0.0100, tip, 0.0072, palette_.limb, 0.004);
  const Vector3d along = (fold - kEarRoot).normalized(), down = (tip - fold).normalized();
  const Joint at_head{kEarRoot, along, 0.012, 0.030, 60, {Between(kEarRoot, fold, 0.4), fold, tip},
                      0.0135,   0.006};
  const Joint at_fold{fold, down, 0.003, 0.021, 70, {Between(fold, tip, 0.2), tip}, 0.0125, 0.005};
  limbs_.push_back({"left_ear", {at_head, at_fold}, tip + 0.007 * down});
  Name("ear_fold", fold + Vector3d(0, 0, 0.0100));
  Name("ear_tip", tip + Vector3d(0.0055, -0.001, -0.0050));
  const Vector3d horn = Vary(Vector3d(-0.043, 0.006, 0.200), 0.004);
  Add({-0.032, 0.0, 0.178}, 0.0115, horn, 0.0045, palette_.horn, 0.004);
  Name("horn_tip", horn + Vector3d(-0.002, 0.001, 0.004));
}

void Sculptor::Arms() {
  LeftArm();
  RightArm();
}

void Sculptor::LeftArm() {
  shoulder_ = Vector3d(0.026, 0.000, 0.096);
  const Vector3d hand = Vary(Vector3d(0.089, -0.008, 0.088), 0.004);
  arm_axis_ = (hand - shoulder_).normalized();
  Add(shoulder_, 0.0145, shoulder_ + 0.9 * (hand - shoulder_), 0.0100, palette_.limb, 0.008);
  Ball(hand, 0.0135, palette_.hand, 0.003);
  Add(hand, 0.008, hand + Vector3d(0.004, -0.006, 0.0150), 0.0052, palette_.hand, 0.003);
  Add(hand, 0.009, hand + Vector3d(0.0155, -0.003, 0.0020), 0.0056, palette_.hand, 0.003);
  const Vector3d thumb = hand + Vector3d(0.004, -0.006, 0.015),
                 finger = hand + Vector3d(0.0155, -0.003, 0.002);
  const std::vector<Vector3d> spine = {Between(shoulder_, hand, 0.3), hand, thumb, finger, hand};
  const Joint joint{shoulder_, arm_axis_, 0.014, 0.050, 120, spine, 0.0165, 0.008};
  limbs_.push_back({"left_arm", {joint}, hand + 0.010 * arm_axis_});
  Name("left_thumb", hand + Vector3d(0.0055, -0.0075, 0.0195));
  Name("left_finger", hand + Vector3d(0.021, -0.004, 0.0025));
  Name("left_elbow", shoulder_ + 0.5 * (hand - shoulder_) + Vector3d(0, -0.012, 0));
}

void Sculptor::RightArm() {
  const Vector3d right_shoulder(-0.026, -0.001, 0.096);
  right_shoulder_ = right_shoulder;
  const Vector3d elbow = Vary(Vector3d(-0.064, -0.010, 0.080), 0.003),
                 fist = elbow + Vary(Vector3d(-0.001, -0.036, -0.008), 0.004);
  elbow_ = elbow;
  fist_ = fist;
  forearm_axis_ = (fist - elbow).normalized();
  Add(right_shoulder, 0.0145, elbow, 0.0112, palette_.limb, 0.008);
  Add(elbow, 0.0112, fist, 0.0098, palette_.limb, 0.004);
  Ball(fist, kFistRadius, palette_.hand, 0.003);
  Add(fist, 0.008, fist + kThumb, kThumbRadius, palette_.hand, 0.003);
  const Vector3d upper = (elbow - right_shoulder).normalized();
  const std::vector<Vector3d> arm = {Between(right_shoulder, elbow, 0.45), elbow, fist,
                                     fist + kThumb, fist},
                              forearm = {elbow, fist, fist + kThumb, fist};
  const Joint at_shoulder{right_shoulder, upper, 0.012, 0.034, 60, arm, 0.0165, 0.008};
  const Joint at_elbow{elbow, forearm_axis_, 0.006, 0.028, 80, forearm, 0.0160, 0.008};
  limbs_.push_back({"right_arm", {at_shoulder, at_elbow}, fist + 0.010 * forearm_axis_});
  Name("right_elbow", elbow + Vector3d(-0.0095, 0.005, 0));
  Name("right_fist", fist + Vector3d(-0.003, -0.0135, 0));
}

void Sculptor::Tail() {
  const Vector3d root(0.002, 0.030, 0.026),
      middle = Vary(Vector3d(0.020, 0.064, 0.020), 0.003),
      rise = Vary(Vector3d(0.052, 0.078, 0.034), 0.003),
      tip = rise + Vary(Vector3d(0.012, -0.004, 0.026), 0.003);
  Add(root, 0.0200, middle, 0.0145, palette_.body, 0.008);
  Add(middle, 0.0145, rise, 0.0110, palette_.body, 0.004);
  Add(rise, 0.0110, tip, 0.0065, palette_.spike, 0.004);
  const Vector3d first = (middle - root).normalized(), second = (rise - middle).normalized(),
                 last = (tip - rise).normalized();
  const Joint at_root{root,   first, 0.012,
                      0.034,  45,    {Between(root, middle, 0.5), middle, rise, tip},
                      0.0175, 0.008};
  const Joint at_middle{middle, second, 0.004, 0.030, 55, {Between(middle, rise, 0.1), rise, tip},
                        0.0160, 0.008};
  const Joint at_rise{rise, last, 0.002, 0.022, 60, {Between(rise, tip, 0.1), tip}, 0.0130, 0.006};
  limbs_.push_back({"tail", {at_root, at_middle, at_rise}, tip + 0.006 * last});
  Name("tail_bend", middle + Vector3d(0.004, 0.009, 0.0105));
  Name("tail_tip", tip + Vector3d(0.002, -0.001, 0.0062));
}

void Sculptor::Spots() {
  const Vector3d places[] = {{-0.034, 0.018, 0.062}, {0.030, 0.026, 0.052},
                             {-0.018, 0.033, 0.082}, {0.034, 0.004, 0.070},
                             {-0.030, 0.022, 0.172}, {0.012, 0.028, 0.166},
                             {0.044, -0.012, 0.160}, {-0.036, -0.016, 0.146},
                             {0.060, -0.006, 0.102}, {0.020, 0.070, 0.033}};
  for (const Vector3d& place : places)
    clay_.spots.push_back(
        {Vary(place, 0.004),
         Vary(0.0075, 0.3) * (0.75 + 0.06 * static_cast<double>(clay_.spots.size())),
         palette_.spot});
}

// The upper arm rotates about its axis, so that the forearm hangs; then the forearm bends inwards
// until the fist is pressed into the hip.
Pose Sculptor::HipPose(double turn_degrees, double bend_degrees) const {
  Deformation turn;
  turn.kind = Deformation::Kind::kTwist;
  turn.origin = right_shoulder_;
  turn.axis = (elbow_ - right_shoulder_).normalized();
  turn.begin = 0.014;
  turn.end = 0.040;
  turn.angle = -turn_degrees * kPi / 180;
  const Vector3d upper_arm = right_shoulder_ + 0.45 * (elbow_ - right_shoulder_),
                 thumb = fist_ + Vector3d(0.008, -0.008, 0.007);
  turn.spine = {upper_arm, elbow_, fist_, thumb};
  turn.radius = 0.016;
  turn.falloff = 0.008;
  const Vector3d hanging = Eigen::AngleAxisd(turn.angle, turn.axis) * forearm_axis_,
                 inwards(0.9, 0.35, -0.25);
  Deformation bend = LimbBend(elbow_, hanging, inwards, 0.006, 0.030, bend_degrees, elbow_, 0.016);
  bend.spine = {elbow_, fist_, thumb};
  return {"hip", {turn, bend}, true};
}

Pose Sculptor::HandOnHip() const {
  constexpr double kPressed = 0.0034, kClear = 0.004;  // [m] into the hip; between hand and thigh
  const auto fist_gap = [&](const Clay& clay, const Pose& pose) {
    return clay.Distance(pose(fist_)) - kFistRadius;
  };
  const Vector3d thumb = fist_ + kThumb;
  const auto thumb_gap = [&](const Clay& clay, const Pose& pose) {
    return clay.Distance(pose(thumb)) - kThumbRadius;
  };
  Pose best;
  double least = std::numeric_limits<double>::infinity();
  // Fist and thumb must sink in equally, so that no pinhole remains between them, and the hand must
  // stay clear of the thigh.
  for (double turn = 90; turn > 30; turn -= 2) {
    double low = 0, high = 80;
    for (int round = 0; round < 40; ++round) {
      const Pose pose = HipPose(turn, (low + high) / 2);
      const bool pressed = std::min(fist_gap(trunk_, pose), thumb_gap(trunk_, pose)) < -kPressed;
      (pressed ? high : low) = (low + high) / 2;
    }
    const Pose pose = HipPose(turn, low);
    const double fist = fist_gap(trunk_, pose), uneven = std::abs(fist - thumb_gap(trunk_, pose));
    const bool clear = std::min(fist_gap(thighs_, pose), thumb_gap(thighs_, pose)) > kClear;
    if (clear && fist < 0 && uneven < least) {
      least = uneven;
      best = pose;
    }
  }
  return best;
}

std::vector<Pose> Sculptor::Poses() const {
  const auto left_arm = [&](double degrees) {
    return LimbBend(shoulder_, arm_axis_, Vector3d::UnitZ(), 0.018, 0.048, degrees,
                    shoulder_ + 0.055 * arm_axis_, 0.045);
  };
  const auto forearm = [&](double degrees) {
    return LimbBend(elbow_, forearm_axis_, Vector3d::UnitZ(), 0.006, 0.026, degrees,
                    elbow_ + 0.032 * forearm_axis_, 0.026);
  };
  const auto tail = [](double degrees) {
    return LimbBend({0.002, 0.030, 0.024}, Vector3d::UnitY(), -Vector3d::UnitX(), 0.012, 0.036,
                    degrees, {0.035, 0.065, 0.035}, 0.045);
  };
  const auto lean = [](double degrees, const Vector3d& towards) {
    return LimbBend({0, 0, 0.03}, Vector3d::UnitZ(), towards, 0, 0.075, degrees);
  };
  const auto head = [](double degrees) { return TrunkTwist(0.112, 0.142, degrees); };
  const Vector3d forward = -Vector3d::UnitY(), left = Vector3d::UnitX();
  return {{"rest", {}},
          {"bent", {head(24), left_arm(52), tail(34), lean(7, -left), WholeSquash(0.96)}},
          {"wave", {left_arm(80), forearm(45), head(-15)}},
          {"bow", {left_arm(-25), head(10), lean(22, forward)}},
          {"squash", {WholeSquash(0.85)}},
          {"twist", {TrunkTwist(0.03, 0.11, 35)}},
          HandOnHip()};
}

Character SculptCreature(std::uint64_t seed) {
  Sculptor sculptor(seed);
  sculptor.Sculpt();
  return {sculptor.clay(), sculptor.places(), sculptor.Poses(), sculptor.limbs()};
}

// The vertex nearest to each named place. If several places share a vertex, only the first name is
// kept.
std::vector<TruthLandmark> FindLandmarks(
    const Mesh& rest, const std::vector<std::pair<std::string, Vector3d>>& places) {
  const KdTree tree(rest.points);
  std::vector<TruthLandmark> landmarks;
  for (const auto& [name, place] : places) landmarks.push_back({name, tree.Nearest(place).index});
  return landmarks;
}

void RequireValid(const WorldOptions& options) {
  if (options.character != "creature" && options.character != "columns")
    throw UsageError("synth: character is '" + options.character +
                     "'; it can be creature or columns");
  if (options.pose_seed > 0 && options.character != "creature")
    throw UsageError("synth: the pose 'limbs' is one of the creature; leave --pose-seed out");
  if (options.texture != "rich" && options.texture != "weak" && options.texture != "none")
    throw UsageError("synth: texture is '" + options.texture + "'; it can be rich, weak or none");
  if (!(options.spacing_m > 0.0003 && options.spacing_m < 0.02))
    throw InputError("synth: spacing_m must be in (0.0003, 0.02) metres");
  if (!(options.print_height_m >= 0 && options.print_spacing_m > 0 &&
        options.print_height_m < 0.2 * options.print_spacing_m))
    throw InputError("synth: prints need a spacing above 0 and a height below a fifth of it");
  // Vertices are about spacing_m / 2 apart; fewer than six per ridge would cut off its crest.
  if (options.prints_move && options.spacing_m > options.print_spacing_m / 3)
    throw InputError(
        "synth: prints that move the surface need spacing_m of at most a third of their own "
        "spacing, " +
        std::to_string(options.print_spacing_m / 3) + " m");
}

void PressPrints(const Clay& clay, PointsX3* points) {
  const auto press = [&](std::int64_t i) {
    const Vector3d x = points->row(i);
    const double height = clay.RidgeHeight(x, clay.LumpAt(x));
    if (height != 0) points->row(i) += height * clay.Gradient(x).normalized().transpose();
  };
  ParallelFor(points->rows(), press, 512);
}

}  // namespace

const Pose& World::PoseNamed(const std::string& name) const {
  std::string known;
  for (const Pose& pose : poses) {
    if (pose.name == name) return pose;
    known += (known.empty() ? "" : ", ") + pose.name;
  }
  throw UsageError("synth: there is no pose '" + name + "'; there are " + known);
}

World MakeWorld(const WorldOptions& options) {
  RequireValid(options);
  Character character =
      options.character == "columns" ? SculptColumns(options.seed) : SculptCreature(options.seed);
  World world;
  world.clay = std::move(character.clay);
  world.spacing_m = options.spacing_m;
  if (options.texture == "weak") world.clay.grain = 0.12;
  if (options.texture == "none") {
    world.clay.grain = 0;
    world.clay.spots.clear();
  }
  world.clay.ridge_height = options.print_height_m;
  world.clay.ridge_spacing = options.print_spacing_m;
  world.poses = std::move(character.poses);
  world.limbs = std::move(character.limbs);
  if (options.pose_seed > 0)
    world.poses.push_back(RandomLimbPose(world.clay, world.limbs, options.pose_seed));
  Vector3d low, high;
  world.clay.Bounds(&low, &high);
  world.rest = Polygonize([&](const Vector3d& x) { return world.clay.Distance(x); }, low, high,
                          options.spacing_m);
  world.smooth = world.rest.points;
  if (options.prints_move) PressPrints(world.clay, &world.rest.points);
  world.landmarks = FindLandmarks(world.rest, character.places);
  return world;
}

Mesh TruthSurface(const World& world, const Pose& pose, bool with_colors) {
  Mesh surface;
  surface.points = pose(world.rest.points);
  surface.faces = world.rest.faces;
  if (!with_colors) return surface;
  surface.colors.resize(surface.points.rows(), 3);
  const auto paint = [&](std::int64_t i) {
    const Vector3d x = world.rest.points.row(i);
    const Vector3d color = world.clay.Paint(x, world.clay.LumpAt(x));
    for (int c = 0; c < 3; ++c) {
      surface.colors(i, c) = static_cast<std::uint8_t>(
          std::lround(255 * std::clamp(SrgbFromLinear(color[c]), 0.0, 1.0)));
    }
  };
  ParallelFor(surface.points.rows(), paint, 512);
  return surface;
}

Mesh SeenSurface(const World& world, const Pose& pose) {
  Mesh surface = TruthSurface(world, pose);
  return pose.touches ? OuterSurface(surface, world.spacing_m) : surface;
}

PointsX3 LandmarkPositions(const World& world, const Pose& pose) {
  PointsX3 positions(std::ssize(world.landmarks), 3);
  for (std::size_t i = 0; i < world.landmarks.size(); ++i)
    positions.row(i) = pose(Vector3d(world.rest.points.row(world.landmarks[i].vertex))).transpose();
  return positions;
}

}  // namespace keypose::synth
