#include "synth/worlds/limbed_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/mesh.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr double kGoldenAngle = 2.399963229728653;  // successive places around a limb never align
constexpr int kAttempts = 60;

// The last point at which a ray from inside leaves the solid.
Vector3d Exit(const Clay& clay, const Vector3d& from, const Vector3d& direction) {
  const Vector3d unit = direction.normalized();
  double outside = 0.3, inside = 0;
  for (double t = outside; t > 0; t -= 0.0005)
    if (clay.Distance(from + t * unit) < 0) {
      inside = t;
      outside = t + 0.0005;
      break;
    }
  for (int i = 0; i < 40; ++i) {
    const double middle = (inside + outside) / 2;
    (clay.Distance(from + middle * unit) < 0 ? inside : outside) = middle;
  }
  return from + outside * unit;
}

// A straight limb in the rest pose.
struct Limb {
  std::string name;
  Vector3d root, axis;
  double length, radius, tip_radius;
  double begin;      // [m] along the axis: start of the part that may bend
  bool alone;        // no other part lies beyond `begin`
  double share = 1;  // of the requested bend
  double azimuth = 0;

  Vector3d At(double s) const { return root + s * axis; }
  Vector3d Across(double angle) const {
    const Vector3d u = axis.unitOrthogonal();
    return std::cos(angle) * u + std::sin(angle) * axis.cross(u);
  }
};

struct Sketch {
  Clay clay;
  std::vector<Limb> limbs;
  std::vector<Place> body;  // places on no limb
};

void AddLimb(Sketch* sketch, const Limb& limb, double blend) {
  Lump lump;
  lump.a = limb.At(-0.012);
  lump.b = limb.At(limb.length - limb.tip_radius);
  lump.ra = limb.radius;
  lump.rb = limb.tip_radius;
  lump.blend = blend;
  sketch->clay.lumps.push_back(lump);
  sketch->limbs.push_back(limb);
}

void AddBall(Clay* clay, const Vector3d& a, double ra, const Vector3d& b, double rb, double blend,
             bool crisp = false) {
  Lump lump;
  lump.a = a;
  lump.b = b;
  lump.ra = ra;
  lump.rb = rb;
  lump.blend = blend;
  lump.crisp = crisp;
  clay->lumps.push_back(lump);
}

// Varies a value by up to +-share of it; seed 0 varies nothing.
class Variation {
 public:
  explicit Variation(std::uint64_t seed) : random_(Hash(seed) + 5), spread_(seed == 0 ? 0 : 1) {}
  double operator()(double low, double plain, double high) {
    const double u = random_.Uniform();
    return spread_ == 0 ? plain : low + (high - low) * u;
  }

 private:
  Random random_;
  double spread_;
};

Sketch SketchTentacle(std::uint64_t seed) {
  Variation vary(seed);
  Sketch sketch;
  sketch.clay.seed = static_cast<std::uint32_t>(Hash(seed + 11) & 0xffffff);
  sketch.clay.flat_base = false;
  const double azimuth = vary(0, 0, 2 * kPi), radius = vary(0.0105, 0.012, 0.0135);
  Limb limb{"tentacle",
            Vector3d::Zero(),
            Vector3d::UnitZ(),
            0.2,
            radius,
            radius * vary(0.6, 1, 1),
            0.006,
            true,
            1,
            azimuth};
  const Vector3d side = limb.Across(azimuth), across = limb.axis.cross(side);
  // The bulb is shifted away from the side where the tip arrives at 270 degrees.
  const double girth = vary(0.032, 0.035, 0.037), back = vary(0.012, 0.014, 0.018);
  const Vector3d center = -back * side - std::sqrt(girth * girth - back * back) * limb.axis;
  const Vector3d lean =
      (-vary(0, 0.3, 0.8) * side + vary(-0.8, 0.3, 0.8) * across - vary(0.2, 0.6, 1) * limb.axis)
          .normalized();
  AddBall(&sketch.clay, center, girth, center + girth * vary(0.3, 0.5, 0.8) * lean,
          girth * vary(0.6, 0.8, 0.9), 0.01);
  AddLimb(&sketch, limb, 0.01);
  // Eyes and a toe: without them the bulb would fit at any rotation about the tentacle.
  const auto towards = [&](double turn, double rise) {
    return (std::cos(turn) * side + std::sin(turn) * across + rise * limb.axis).normalized();
  };
  const Vector3d eyes[2] = {towards(vary(1.4, 1.6, 1.8), vary(-0.2, 0, 0.2)),
                            towards(vary(2.4, 2.5, 2.7), vary(0, 0.2, 0.3))};
  const double sizes[2] = {vary(0.007, 0.009, 0.010), vary(0.006, 0.007, 0.009)};
  for (int i = 0; i < 2; ++i) {
    const Vector3d eye = Exit(sketch.clay, center, eyes[i]) - 0.15 * sizes[i] * eyes[i];
    AddBall(&sketch.clay, eye, sizes[i], eye, sizes[i], 0.002, true);
  }
  const Vector3d toe = towards(vary(-2.2, -1.9, -1.6), vary(-0.9, -0.6, -0.4));
  AddBall(&sketch.clay, center, 0.014, center + (girth + 0.012) * toe, 0.009, 0.008);
  const std::pair<const char*, Vector3d> names[6] = {
      {"left_eye", eyes[0]},        {"right_eye", eyes[1]},        {"toe", toe},
      {"bottom", towards(0.3, -3)}, {"front", towards(0.0, -0.5)}, {"back", towards(3.9, 0.1)}};
  for (const auto& [name, direction] : names)
    sketch.body.push_back({name, Exit(sketch.clay, center, direction)});
  return sketch;
}

Sketch SketchCharacter(std::uint64_t seed) {
  Variation vary(seed);
  Sketch sketch;
  sketch.clay.seed = static_cast<std::uint32_t>(Hash(seed + 12) & 0xffffff);
  sketch.clay.flat_base = false;
  const double girth = vary(0.027, 0.030, 0.033);
  const Vector3d hip(0, 0, 0), chest(vary(-0.004, 0.002, 0.004), 0, vary(0.046, 0.05, 0.056)),
      head(vary(-0.006, 0.002, 0.006), -0.006, 0.112);
  AddBall(&sketch.clay, hip, girth, chest, girth * vary(0.8, 0.88, 1), 0.01);
  AddBall(&sketch.clay, chest, 0.016, head, 0.014, 0.01);
  AddBall(&sketch.clay, head, vary(0.021, 0.024, 0.026), head + Vector3d(0, 0.004, 0.006), 0.022,
          0.008);
  AddBall(&sketch.clay, head + Vector3d(0.003, -0.018, -0.004), 0.012,
          head + Vector3d(0.004, -0.028, -0.006), 0.0075, 0.005);
  const auto limb = [&](const char* name, const Vector3d& from, const Vector3d& axis, double length,
                        double radius) {
    const Vector3d unit = axis.normalized(), root = Exit(sketch.clay, from, unit);
    const double thick = radius * vary(0.9, 1, 1.1);
    AddLimb(&sketch,
            {name, root, unit, length * vary(0.85, 1, 1.15), thick, thick * vary(0.65, 0.8, 1),
             thick, false},
            0.006);
  };
  Sketch torso = sketch;
  limb("left_arm", chest, {1, vary(-0.3, -0.1, 0.3), vary(-0.1, 0.15, 0.3)}, 0.11, 0.010);
  limb("right_arm", chest, {-1, vary(-0.3, 0, 0.3), vary(-0.1, 0.1, 0.3)}, 0.12, 0.0105);
  limb("left_leg", hip, {vary(0.5, 0.6, 0.7), vary(-0.3, -0.2, 0), -1}, 0.10, 0.0125);
  limb("right_leg", hip, {-vary(0.5, 0.6, 0.7), vary(-0.3, -0.1, 0), -1}, 0.105, 0.012);
  limb("tail", hip, {vary(-0.2, 0.1, 0.2), 1, vary(-0.1, 0.1, 0.3)}, 0.13, 0.0105);
  const std::pair<const char*, Vector3d> names[3] = {
      {"chest", {0.3, -1, 0.1}}, {"back", {-0.2, 1, 0.6}}, {"belly", {0.1, -1, -0.2}}};
  sketch.body.push_back({"nose", Exit(torso.clay, head, {0.1, -1, -0.2})});
  sketch.body.push_back({"crown", Exit(torso.clay, head, {0, 0.1, 1})});
  sketch.body.push_back({"left_cheek", Exit(torso.clay, head, {1, -0.2, 0})});
  for (const auto& [name, direction] : names)
    sketch.body.push_back({name, Exit(torso.clay, (hip + chest) / 2, direction)});
  return sketch;
}

// Tips, then the body, then alternately around and along the limbs.
std::vector<Place> PlacesOf(const Sketch& sketch, int count) {
  std::vector<Place> places;
  for (const Limb& limb : sketch.limbs)
    places.push_back({limb.name + "_tip", Exit(sketch.clay, limb.At(limb.length / 2), limb.axis)});
  places.insert(places.end(), sketch.body.begin(), sketch.body.end());
  const int limbs = SizeOf(sketch.limbs), left = std::max(0, count - SizeOf(places));
  const int each = (left + limbs - 1) / limbs;
  for (int i = 0; i < left; ++i) {
    const Limb& limb = sketch.limbs[i % limbs];
    const int row = i / limbs;
    const double s = limb.begin + (limb.length - limb.begin) * (row + 1) / (each + 1);
    places.push_back(
        {limb.name + "_" + std::to_string(row + 1),
         Exit(sketch.clay, limb.At(s), limb.Across(limb.azimuth + row * kGoldenAngle))});
  }
  places.resize(std::min<std::size_t>(places.size(), static_cast<std::size_t>(count)));
  return places;
}

Pose PoseOf(const std::vector<Limb>& limbs, const LimbedShapeOptions& options) {
  Pose pose{options.shape, {}};
  for (const Limb& limb : limbs) {
    Deformation move;
    move.origin = limb.root;
    move.axis = limb.axis;
    move.begin = limb.begin;
    move.end = limb.length;
    move.reach = limb.alone ? 0 : 2.2 * limb.radius;
    move.falloff = 0.003;
    move.kind = Deformation::Kind::kTwist;
    move.angle = options.twist_deg * kPi / 180;
    if (move.angle != 0) pose.steps.push_back(move);
    move.kind = Deformation::Kind::kBend;
    move.angle = limb.share * options.bend_deg * kPi / 180;
    move.hinge = move.axis.cross(limb.Across(limb.azimuth));
    pose.steps.push_back(move);
  }
  Deformation squash;
  squash.kind = Deformation::Kind::kSquash;
  squash.ratio = options.squash;
  if (options.squash != 1) pose.steps.push_back(squash);
  return pose;
}

// Whether parts that were more than four radii apart stay apart.
bool StaysApart(const PointsX3& rest, const PointsX3& posed) {
  constexpr double kFar = 0.05, kApart = 0.008;
  for (Eigen::Index i = 0; i < rest.rows(); ++i)
    for (Eigen::Index j = i + 1; j < rest.rows(); ++j)
      if ((posed.row(i) - posed.row(j)).squaredNorm() < kApart * kApart &&
          (rest.row(i) - rest.row(j)).squaredNorm() > kFar * kFar)
        return false;
  return true;
}

PointsX3 Sample(const Clay& clay) {
  Vector3d low, high;
  clay.Bounds(&low, &high);
  constexpr double kSpacing = 0.008;
  return Polygonize([&](const Vector3d& x) { return clay.Distance(x); },
                    low - Vector3d::Constant(kSpacing), high + Vector3d::Constant(kSpacing),
                    kSpacing)
      .points;
}

}  // namespace

std::vector<std::string> LimbedShapeOptions::Problems() const {
  std::vector<std::string> problems;
  if (shape != "tentacle" && shape != "character")
    problems.push_back("shape is '" + shape + "'; it can be tentacle or character");
  if (!(bend_deg >= 0 && bend_deg <= 280))
    problems.push_back("bend must be 0 to 280 degrees: a plane curve closes on itself beyond");
  if (!(std::abs(twist_deg) <= 720)) problems.push_back("twist must be -720 to 720 degrees");
  if (!(squash >= 0.5 && squash <= 2)) problems.push_back("squash must be 0.5 to 2");
  if (places < 0 || places > 60) problems.push_back("there are 0 to 60 landmarks");
  return problems;
}

LimbedShape MakeLimbedShape(const LimbedShapeOptions& options) {
  if (const auto problems = options.Problems(); !problems.empty())
    throw UsageError("synth: " + problems.front());
  Sketch sketch =
      options.shape == "tentacle" ? SketchTentacle(options.seed) : SketchCharacter(options.seed);
  const PointsX3 rest = Sample(sketch.clay);
  LimbedShape shape{sketch.clay, {}, PlacesOf(sketch, options.places)};
  Random random(Hash(options.seed) + 31);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    for (Limb& limb : sketch.limbs)
      if (!limb.alone) {
        limb.azimuth = random.Uniform(0, 2 * kPi);
        limb.share = random.Uniform(0.6, 1);
      }
    shape.pose = PoseOf(sketch.limbs, options);
    if (StaysApart(rest, shape.pose(rest))) return shape;
  }
  throw InputError("synth: the limbs of seed " + std::to_string(options.seed) +
                   " touch whichever way they bend by " + std::to_string(options.bend_deg) +
                   " degrees; bend less or take another seed");
}

}  // namespace keypose::synth
