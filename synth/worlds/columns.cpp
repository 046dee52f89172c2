#include "synth/worlds/columns.h"

#include <cmath>

#include "core/pictures/srgb.h"
#include "core/values/angles.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

Vector3d FromSrgb(int r, int g, int b) {
  return {LinearFromSrgb(r / 255.0), LinearFromSrgb(g / 255.0), LinearFromSrgb(b / 255.0)};
}

class Builder {
 public:
  explicit Builder(std::uint64_t seed) : random_(seed), spread_(seed == 1 ? 0 : 1) {
    figure_.clay.seed = static_cast<std::uint32_t>(Hash(seed + 77) & 0xffffff);
  }

  Character Build() {
    Base();
    Columns();
    Torso();
    Head();
    Arm();
    Poses();
    return std::move(figure_);
  }

 private:
  double Vary(double value, double share) {
    return value * (1 + spread_ * random_.Uniform(-share, share));
  }
  void Add(const Vector3d& a, double ra, const Vector3d& b, double rb, const Vector3d& color,
           double blend = 0.005, bool crisp = false) {
    figure_.clay.lumps.push_back({a, b, ra, rb, blend, color, crisp});
  }
  void Name(const char* name, const Vector3d& place) { figure_.places.emplace_back(name, place); }

  /// A slab of clay without holes: two rings of lumps around its middle.
  void Slab(double height, double radius, double thickness, const Vector3d& color) {
    constexpr int kLinks = 10;
    Add({-0.008, 0, height}, thickness, {0.009, 0.002, height}, thickness, color, 0.008);
    for (const double share : {0.55, 1.0})
      for (int i = 0; i < kLinks; ++i) {
        const auto at = [&](int k) {
          const double angle = 2 * kPi * k / kLinks;
          return Vector3d(share * radius * std::cos(angle), 0.9 * share * radius * std::sin(angle),
                          height);
        };
        Add(at(i), thickness, at(i + 1), thickness, color, 0.004);
      }
  }

  void Base() { Slab(0.006, 0.036, 0.0095, FromSrgb(112, 96, 84)); }

  void Columns() {
    const double angles[4] = {-62, 34, 118, 205}, radii[4] = {0.0082, 0.0068, 0.0090, 0.0074};
    const Vector3d colors[4] = {FromSrgb(204, 112, 76), FromSrgb(84, 150, 130),
                                FromSrgb(238, 196, 92), FromSrgb(128, 104, 160)};
    const char* names[4] = {"front_column", "left_column", "back_column", "right_column"};
    for (int i = 0; i < 4; ++i) {
      const double angle = (angles[i] + spread_ * random_.Uniform(-7, 7)) * kPi / 180,
                   radius = Vary(radii[i], 0.1);
      const Vector3d outwards(std::cos(angle), std::sin(angle), 0);
      const Vector3d foot = 0.036 * outwards + Vector3d(0, 0, 0.010),
                     top = Vary(0.030, 0.08) * outwards + Vector3d(0, 0, 0.086);
      Add(foot, radius * 1.1, top, radius, colors[i], 0.005);
      Name(names[i], 0.5 * (foot + top) + radius * outwards);
    }
  }

  void Torso() {
    Slab(0.092, 0.028, 0.0120, FromSrgb(72, 128, 170));
    Add({0, 0, 0.098}, 0.028, {0.003, -0.002, 0.122}, 0.020, FromSrgb(72, 128, 170), 0.010);
    Add({0.004, -0.0245, 0.109}, 0.0050, {0.004, -0.0245, 0.109}, 0.0050, FromSrgb(226, 96, 70),
        0.001, true);
    Name("button", {0.004, -0.0295, 0.109});
    Add({-0.002, 0.024, 0.110}, 0.0085, {-0.006, 0.043, 0.121}, 0.0026, FromSrgb(236, 176, 70),
        0.003);
    Name("back_spike", {-0.0066, 0.0452, 0.1222});
  }

  void Head() {
    const Vector3d middle(0.004, -0.004, 0.156);
    Add(middle - Vector3d(0.010, 0, 0), Vary(0.026, 0.06), middle + Vector3d(0.012, 0, 0.001),
        Vary(0.024, 0.06), FromSrgb(226, 204, 150), 0.010);
    const Vector3d nose = middle + Vector3d(0.003, -0.031, -0.004);
    Add(middle + Vector3d(0.002, -0.016, -0.003), 0.0105, nose, 0.0070, FromSrgb(214, 108, 120),
        0.005);
    Name("nose", nose + Vector3d(0, -0.0070, 0));
    Add(middle + Vector3d(0.015, -0.021, 0.009), 0.0072, middle + Vector3d(0.015, -0.021, 0.009),
        0.0072, FromSrgb(246, 242, 232), 0.001, true);
    Add(middle + Vector3d(-0.011, -0.022, 0.008), 0.0062, middle + Vector3d(-0.011, -0.022, 0.008),
        0.0062, FromSrgb(40, 36, 44), 0.001, true);
    Name("left_eye", middle + Vector3d(0.0160, -0.0282, 0.0098));
    const Vector3d horn = middle + Vector3d(-0.030, 0.004, 0.041);
    Add(middle + Vector3d(-0.017, 0, 0.018), 0.0105, horn, 0.0042, FromSrgb(206, 74, 62), 0.004);
    Name("horn_tip", horn + Vector3d(-0.0016, 0, 0.0038));
    Add(middle + Vector3d(0.030, 0.002, 0.006), 0.0090, middle + Vector3d(0.047, 0.005, -0.006),
        0.0062, FromSrgb(86, 118, 58), 0.004);
    Name("ear_tip", middle + Vector3d(0.0520, 0.0058, -0.0098));
  }

  void Arm() {
    const Vector3d shoulder(0.017, -0.002, 0.116), hand(0.066, -0.014, 0.103);
    Add(shoulder, 0.0125, hand, 0.0088, FromSrgb(150, 176, 84), 0.006);
    Add(hand, 0.0115, hand + Vector3d(0.003, -0.004, 0.013), 0.0052, FromSrgb(236, 176, 70), 0.003);
    Name("thumb", hand + Vector3d(0.0042, -0.0056, 0.0179));
    figure_.clay.spots = {{{-0.024, 0.018, 0.100}, 0.008, FromSrgb(42, 70, 116)},
                          {{0.004, 0.022, 0.160}, 0.009, FromSrgb(190, 96, 80)},
                          {{-0.026, -0.014, 0.094}, 0.007, FromSrgb(240, 224, 190)},
                          {{0.042, -0.012, 0.118}, 0.006, FromSrgb(42, 104, 116)},
                          {{0.030, 0.020, 0.092}, 0.008, FromSrgb(228, 128, 62)}};
  }

  void Poses() {
    const Vector3d shoulder(0.017, -0.002, 0.116), hand(0.066, -0.014, 0.103);
    Deformation raise =
        LimbBend(shoulder, hand - shoulder, Vector3d::UnitZ(), 0.014, 0.034, 45, hand, 0.014);
    raise.spine = {shoulder + 0.5 * (hand - shoulder), hand, hand + Vector3d(0.003, -0.004, 0.013)};
    // The columns lean as if the torso were pushed to one side.
    const Deformation lean =
        LimbBend({0, 0, 0.02}, Vector3d::UnitZ(), -Vector3d::UnitX(), 0, 0.060, 12);
    figure_.poses = {{"rest", {}},
                     {"bent", {raise, TrunkTwist(0.122, 0.146, 22), lean}},
                     {"twist", {TrunkTwist(0.02, 0.084, 28)}},
                     {"squash", {WholeSquash(0.88)}}};
  }

  Random random_;
  double spread_;  // 0: standard proportions
  Character figure_;
};

}  // namespace

Character SculptColumns(std::uint64_t seed) { return Builder(seed).Build(); }

}  // namespace keypose::synth
