#include "motion/tracking/actor_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

constexpr int kRadii = kStations * kHarmonics;
constexpr int kShape = kLengths + kSegments * kRadii;
constexpr int kScales = 2;  // of the average's lengths and girths; no prior holds them
constexpr int kFirstPose = kShape + kScales;

/// A row of the least squares system, in few numbers.
struct SparseRow {
  std::vector<std::pair<int, double>> entries;
  double value = 0;
};

class System {
 public:
  explicit System(int unknowns)
      : matrix_(Eigen::MatrixXd::Zero(unknowns, unknowns)),
        gradient_(Eigen::VectorXd::Zero(unknowns)) {}

  void Add(const SparseRow& row) {
    cost_ += row.value * row.value;
    for (const auto& [i, a] : row.entries) {
      gradient_[i] += a * row.value;
      for (const auto& [j, b] : row.entries)
        if (j <= i) matrix_(i, j) += a * b;
    }
  }
  void AddPose(int first, const PoseSystem& system) {
    matrix_.block<kDofs, kDofs>(first, first) += system.matrix;
    gradient_.segment<kDofs>(first) += system.gradient;
    cost_ += system.cost;
  }
  /// What is added of robust losses, whose rows hold only slopes.
  void AddCost(double cost) { cost_ += cost; }
  double cost() const { return cost_; }
  Eigen::VectorXd Step() {
    matrix_.diagonal().array() += 1e-6 * matrix_.diagonal().array() + 1e-3;
    return -matrix_.selfadjointView<Eigen::Lower>().llt().solve(gradient_);
  }

 private:
  Eigen::MatrixXd matrix_;  // lower half
  Eigen::VectorXd gradient_;
  double cost_ = 0;
};

/// One frame's rows at one linearisation.
struct FrameRows {
  std::vector<SparseRow> rows;
  double cost = 0;
};

SparseRow RowOf(const OutlineResidual& r, const PosedBody& body, double weight, int first_pose) {
  const OutlineSample& sample = *r.sample;
  const int joint = Segments()[sample.segment].joint;
  const double root = std::sqrt(weight);
  std::array<double, kDofs> pose{};
  std::array<double, kLengths> lengths{};
  std::array<double, kRadii> radii{};
  const Eigen::Vector3d pull = root * r.pull;
  body.AddPoseRow(joint, r.x, pull, pose.data());
  body.AddLengthRow(joint, pull, lengths.data());
  const Eigen::Vector3d local = body.rotation[joint].transpose() * pull;
  AddSurfaceRow(sample.segment, sample.a, local, 1 - sample.share, lengths.data(), radii.data());
  AddSurfaceRow(sample.segment, sample.b, local, sample.share, lengths.data(), radii.data());
  SparseRow row;
  row.value = root * r.value;
  const auto take = [&](const auto& numbers, int first) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (numbers[i] != 0) row.entries.emplace_back(first + static_cast<int>(i), numbers[i]);
  };
  take(lengths, 0);
  take(radii, kLengths + sample.segment * kRadii);
  take(pose, first_pose);
  return row;
}

FrameRows RowsOfFrame(const ActorFrame& frame, const BodyShape& shape, const LocalSurface& surface,
                      double reach, int first_pose) {
  const PosedBody body = Posed(frame.pose, shape);
  const std::vector<ViewMatches> matches =
      FindAllMatches(frame.silhouettes, surface, body, 2 * reach);
  std::vector<FrameRows> views(matches.size());
  ParallelFor(SizeOf(views), [&](std::int64_t v) {
    VisitResiduals(frame.silhouettes[v], matches[v], body, [&](const OutlineResidual& r) {
      views[v].cost += r.stands_for * 2 * TukeyLoss(r.value, reach);
      const double weight = ActorTuning::kTrust * r.stands_for * TukeyWeight(r.value, reach);
      if (weight > 0) views[v].rows.push_back(RowOf(r, body, weight, first_pose));
    });
  });
  FrameRows all;
  for (FrameRows& view : views) {
    all.cost += view.cost;
    std::move(view.rows.begin(), view.rows.end(), std::back_inserter(all.rows));
  }
  return all;
}

/// Hands and feet.
bool IsEnd(int segment) { return segment >= 4 && segment % 3 == 0; }

int RadiusAt(int segment, int station, int harmonic) {
  return kLengths + segment * kRadii + station * kHarmonics + harmonic;
}

/// Rows that prefer proportion, smoothness and symmetry.
class ShapePrior {
 public:
  ShapePrior(const BodyShape& shape, const Eigen::Vector2d& scales, const ActorOptions& options,
             System* system)
      : shape_(shape),
        average_(AverageShape()),
        scales_(scales),
        options_(options),
        system_(system) {}

  void Add() {
    for (int i = 0; i < kLengths; ++i) {
      const double average = average_.lengths[i];
      const double sigma = ActorTuning::kLength * average + 0.005;
      Put({{i, 1}, {kShape, -average}}, shape_.lengths[i] - scales_[0] * average, sigma);
    }
    for (int i = kClavicleWidth; i < kClavicleWidth + kRight; ++i)
      Put({{i, 1}, {i + kRight, -1}}, shape_.lengths[i] - shape_.lengths[i + kRight],
          ActorTuning::kSideLength * average_.lengths[i]);
    for (int s = 0; s < kSegments; ++s)
      for (int m = 0; m < kHarmonics; ++m) AddRadii(s, m);
    for (int s = 4; s < kSegments; ++s)
      if (s < 7 || (s >= 10 && s < 13)) AddSides(s);
  }

 private:
  double Radius(int s, int k, int m) const { return shape_.radii[s](k, m); }

  void AddRadii(int s, int m) {
    const bool limb = s >= 4 && !IsEnd(s);
    // A limb's bone runs through its middle; the trunk, hands and feet may lie beside their axes.
    double girth = limb && m < 3 ? ActorTuning::kOneSided : ActorTuning::kWave;
    if (m == 0) girth = ActorTuning::kGirth;
    const double sigma = options_.waves || m == 0 ? girth : 0.1 * girth;
    for (int k = 0; k < kStations; ++k) {
      const double average = average_.radii[s](k, m);
      Put({{RadiusAt(s, k, m), 1}, {kShape + 1, -average}}, Radius(s, k, m) - scales_[1] * average,
          sigma);
    }
    for (int k = 1; k + 1 < kStations; ++k) {
      // of the difference to the average's, whose own bends are wanted
      double bend = 0;
      for (const auto& [step, factor] : {std::pair{-1, 1.0}, {0, -2.0}, {1, 1.0}})
        bend += factor * (Radius(s, k + step, m) - scales_[1] * average_.radii[s](k + step, m));
      Put({{RadiusAt(s, k - 1, m), 1}, {RadiusAt(s, k, m), -2}, {RadiusAt(s, k + 1, m), 1}}, bend,
          ActorTuning::kBend);
    }
  }

  // Left and right are mirrored in x: arms turn their angle's sign, legs the side that it counts
  // from.
  void AddSides(int s) {
    const bool arm = s < 10;
    for (int k = 0; k < kStations; ++k)
      for (int m = 0; m < kHarmonics; ++m) {
        const int wave = (m + 1) / 2;
        const bool sine = m > 0 && m % 2 == 0;
        const bool odd = arm ? sine : (wave % 2 == 1) != sine;
        const double sign = odd ? -1 : 1;
        Put({{RadiusAt(s, k, m), 1}, {RadiusAt(s + 3, k, m), -sign}},
            Radius(s, k, m) - sign * Radius(s + 3, k, m), ActorTuning::kSides);
      }
  }

  void Put(std::vector<std::pair<int, double>> entries, double value, double sigma) {
    for (auto& entry : entries) entry.second /= sigma;
    system_->Add({std::move(entries), value / sigma});
  }

  const BodyShape& shape_;
  const BodyShape average_;
  const Eigen::Vector2d& scales_;
  const ActorOptions& options_;
  System* system_;
};

void Move(const Eigen::VectorXd& step, std::vector<ActorFrame>* frames, BodyShape* shape,
          Eigen::Vector2d* scales) {
  constexpr double kLargest = 0.4;  // [rad] or [m]
  const double factor = 1 / std::max(1.0, step.cwiseAbs().maxCoeff() / kLargest);
  for (int i = 0; i < kLengths; ++i)
    shape->lengths[i] = std::max(shape->lengths[i] + factor * step[i],
                                 i == kShoulderBack || i == kNeckBack ? -0.1 : 0.02);
  for (int s = 0; s < kSegments; ++s)
    for (int k = 0; k < kStations; ++k)
      for (int m = 0; m < kHarmonics; ++m)
        shape->radii[s](k, m) += factor * step[RadiusAt(s, k, m)];
  *scales += factor * step.segment<kScales>(kShape);
  for (std::size_t f = 0; f < frames->size(); ++f)
    (*frames)[f].pose.q += factor * step.segment<kDofs>(kFirstPose + kDofs * static_cast<int>(f));
}

void AddRows(const FrameRows& rows, System* system) {
  double squares = 0;
  for (const SparseRow& row : rows.rows) {
    system->Add(row);
    squares += row.value * row.value;
  }
  system->AddCost(ActorTuning::kTrust * rows.cost - squares);
}

}  // namespace

double FitActor(std::vector<ActorFrame>* frames, BodyShape* shape, const ActorOptions& options,
                Progress* progress) {
  const BodyShape average = AverageShape();
  Eigen::Vector2d scales(shape->lengths.sum() / average.lengths.sum(), 0);
  for (int s = 0; s < kSegments; ++s)
    scales[1] += shape->radii[s].col(0).sum() / average.radii[s].col(0).sum();
  scales[1] /= kSegments;
  double cost = 0;
  for (int round = 0; round < options.rounds; ++round) {
    if (progress && progress->cancelled()) throw Cancelled();
    const double share =
        options.rounds > 1 ? std::min(1.0, 1.5 * round / (options.rounds - 1)) : 1.0;
    const double reach = options.first_reach * std::pow(options.reach / options.first_reach, share);
    System system(kFirstPose + kDofs * SizeOf(*frames));
    const LocalSurface surface = SurfaceOf(*shape);
    for (int f = 0; f < SizeOf(*frames); ++f) {
      ActorFrame& frame = (*frames)[f];
      const int first_pose = kFirstPose + kDofs * f;
      const FrameRows rows = RowsOfFrame(frame, *shape, surface, reach, first_pose);
      AddRows(rows, &system);
      PoseSystem priors;
      for (const QuadraticPrior& prior : frame.priors) AddQuadratic(prior, frame.pose.q, &priors);
      AddLimits(frame.pose.q, &priors);
      AddOverlaps(Posed(frame.pose, *shape), *shape, &priors);
      system.AddPose(first_pose, priors);
    }
    ShapePrior(*shape, scales, options, &system).Add();
    const Eigen::VectorXd step = system.Step();
    Move(step, frames, shape, &scales);
    cost = system.cost();
    ReportProgress(progress, (round + 1.0) / options.rounds, "the actor's shape");
    const double change = step.head(kLengths).cwiseAbs().maxCoeff();
    if (reach == options.reach && change < ActorTuning::kSettled) break;
  }
  return cost;
}

}  // namespace keypose::motion
