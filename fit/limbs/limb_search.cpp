#include "fit/limbs/limb_search.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/levels/hierarchy.h"
#include "fit/limbs/limb_chain.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 2, 4, 24 and 27 (synth). Costs are over the pixels that show
// the limb.
struct LimbSearchTuning {
  KEYPOSE_TUNED(double, kDoubtful, 0.15);  // limbs that agree better stay as they are
  KEYPOSE_TUNED(double, kGain, 0.02);      // by which a turned limb must be better
  KEYPOSE_TUNED(double, kStill, 0.01);     // of turning a joint by 1 rad
  KEYPOSE_TUNED(double, kSpread, 0.7);     // standard deviation of the turns that are tried [rad]
  KEYPOSE_TUNED(double, kNarrower, 0.6);   // the same around the best, over that
};
using Turns = LimbChain::Turns;

constexpr int kTries = 300, kImproved = 4, kAgain = 2;
constexpr double kFirstStep = 0.35, kLastStep = 0.03;  // of a joint's turn [rad]

/// The mesh that is drawn: fewer faces, whose vertices are some of the mesh's.
struct Drawing {
  std::vector<int> vertices;
  FacesX3 faces;
};

Drawing MakeDrawing(const PointsX3& rest, const FacesX3& faces) {
  constexpr int kVertices = 3500;
  if (rest.rows() > kVertices) {
    std::vector<CoarseLevel> coarse = MakeHierarchy(rest, faces, {kVertices});
    if (!coarse.empty()) return {std::move(coarse[0].fine), std::move(coarse[0].faces)};
  }
  Drawing drawing{std::vector<int>(rest.rows()), faces};
  std::iota(drawing.vertices.begin(), drawing.vertices.end(), 0);
  return drawing;
}

/// Turns of the joints, drawn around none: in turn of one joint and of all. The first is none.
std::vector<Turns> DrawTurns() {
  std::mt19937 random(1);
  const auto normal = [&] {  // the same numbers with every library
    constexpr int kSum = 12;
    double sum = -kSum / 2.0;
    for (int i = 0; i < kSum; ++i) sum += random() / 4294967296.0;
    return sum;
  };
  std::vector<Turns> all(kTries, Turns::Zero());
  for (int t = 1; t < kTries; ++t) {
    const int joint = t % (LimbChain::kJoints + 1);
    for (int i = 0; i < LimbChain::kTurns; ++i) {
      const double angle = LimbSearchTuning::kSpread * normal();
      if (joint == LimbChain::kJoints || i / 3 == joint) all[t][i] = angle;
    }
  }
  return all;
}

/// One limb of a drawing, in all pictures.
class DrawnLimb {
 public:
  struct Try {
    Turns turns = Turns::Zero();
    double cost = 0;
  };

  /// @param now  V x 3, of the drawing's vertices
  DrawnLimb(const Limb& limb, const LimbChain& chain, const LimbPictures& pictures,
            const Drawing& drawing, const PointsX3& now)
      : chain_(chain), pictures_(pictures), now_(now), before_(pictures.Of(now)) {
    for (int d = 0; d < SizeOf(drawing.vertices); ++d) {
      const auto at =
          std::lower_bound(limb.vertices.begin(), limb.vertices.end(), drawing.vertices[d]);
      if (at == limb.vertices.end() || *at != drawing.vertices[d]) continue;
      drawn_.push_back(d);
      of_limb_.push_back(static_cast<int>(at - limb.vertices.begin()));
    }
  }

  bool doubtful() const {
    return before_.wrong + before_.missing > LimbSearchTuning::kDoubtful * before_.pixels;
  }
  bool Improves(const Try& found) const {
    return before_.all - found.cost > LimbSearchTuning::kGain * before_.pixels;
  }
  Try Best() const;

 private:
  double CostOf(const Turns& turns) const {
    PointsX3 points = now_;
    points(drawn_, Eigen::all) = chain_.Turned(turns, of_limb_);
    return pictures_.Of(points).all +
           LimbSearchTuning::kStill * before_.pixels * turns.squaredNorm();
  }
  Try Improved(Try from) const;
  std::vector<Try> BestOf(const std::vector<Turns>& all) const;

  const LimbChain& chain_;
  const LimbPictures& pictures_;
  const PointsX3& now_;
  const LimbCost before_;
  std::vector<int> drawn_, of_limb_;  // the limb's vertices in the drawing, and in the limb
};
using Try = DrawnLimb::Try;

bool Better(const Try& a, const Try& b) { return a.cost < b.cost; }

/// Joint by joint and axis by axis, in steps that become smaller.
Try DrawnLimb::Improved(Try from) const {
  for (double step = kFirstStep; step > kLastStep;) {
    Try best = from;
    for (int i = 0; i < LimbChain::kTurns; ++i)
      for (const double way : {-step, step}) {
        Try next = best;
        next.turns[i] += way;
        next.cost = CostOf(next.turns);
        if (Better(next, best)) best = next;
      }
    if (!Better(best, from)) step /= 2;
    from = best;
  }
  return from;
}

/// The best few of them, improved.
std::vector<Try> DrawnLimb::BestOf(const std::vector<Turns>& all) const {
  std::vector<Try> tries(all.size());
  ParallelFor(SizeOf(all), [&](std::int64_t t) { tries[t] = {all[t], CostOf(all[t])}; });
  std::stable_sort(tries.begin(), tries.end(), Better);
  tries.resize(kImproved);
  ParallelFor(kImproved, [&](std::int64_t t) { tries[t] = Improved(tries[t]); });
  return tries;
}

Try DrawnLimb::Best() const {
  const std::vector<Turns> drawn = DrawTurns();
  std::vector<Try> tries = BestOf(drawn);
  Try best = *std::min_element(tries.begin(), tries.end(), Better);
  for (int again = 0; again < kAgain; ++again) {
    std::vector<Turns> around;
    for (std::size_t t = 0; t < drawn.size(); t += 2)
      around.push_back(best.turns + LimbSearchTuning::kNarrower * drawn[t]);
    tries = BestOf(around);
    tries.push_back(best);
    best = *std::min_element(tries.begin(), tries.end(), Better);
  }
  return best;
}

}  // namespace

TurnedLimbs TurnLimbs(const PointsX3& rest, const FacesX3& faces, const Eigen::MatrixX3f& colors,
                      const std::vector<SmallPicture>& pictures, const PointsX3& now,
                      Progress* progress) {
  TurnedLimbs result{now, std::vector<char>(now.rows(), 0)};
  const Drawing drawing = MakeDrawing(rest, faces);
  const Eigen::MatrixX3f drawn_colors = colors(drawing.vertices, Eigen::all);
  const std::vector<Limb> limbs = FindLimbs(rest, faces);
  for (int l = 0; l < SizeOf(limbs); ++l) {
    ReportProgress(progress, static_cast<double>(l) / SizeOf(limbs), "limbs");
    const Limb& limb = limbs[l];
    std::vector<char> of_limb(now.rows(), 0), of_drawn;
    for (const int v : limb.vertices) of_limb[v] = 1;
    for (const int v : drawing.vertices) of_drawn.push_back(of_limb[v]);
    const PointsX3 drawn_points = result.points(drawing.vertices, Eigen::all);
    const LimbPictures limb_pictures(pictures, drawing.faces, drawn_colors, drawn_points, of_drawn);
    const LimbChain chain(limb, rest, result.points);
    const DrawnLimb drawn(limb, chain, limb_pictures, drawing, drawn_points);
    if (!drawn.doubtful()) continue;
    const Try best = drawn.Best();
    if (!drawn.Improves(best)) continue;
    ++result.count;
    result.points(limb.vertices, Eigen::all) = chain.Turned(best.turns);
    for (const int v : limb.vertices) result.turned[v] = 1;
  }
  return result;
}

}  // namespace keypose::fit
