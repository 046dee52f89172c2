#include "register/nricp/nricp.h"

#include <chrono>
#include <cmath>
#include <iterator>
#include <string>

#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "register/nricp/correspondence.h"

namespace keypose::registration {

namespace {

constexpr double kPcgTolerance = 1e-5;
constexpr int kPcgSteps = 12;  // with more steps, a new factor is cheaper

class Stopwatch {
 public:
  explicit Stopwatch(double& seconds)
      : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

void CheckInputs(const Mesh& source, const Mesh& target, const std::vector<LandmarkGoal>& landmarks,
                 const Eigen::VectorXd& stiffness) {
  RequireUsable(source, "register: source");
  RequireUsable(target, "register: target");
  RequireExtent(target, "register: target");
  RequireUsable(landmarks, source.vertex_count(), "register");
  RequireStiffness(stiffness, source.vertex_count(), "register");
}

/// The similarity that moves the target's mean to the origin and scales its diagonal to 2. The
/// values of alpha, beta and gamma are for this scale.
Similarity3 Normalisation(const PointsX3& points) {
  Similarity3 s;
  s.scale = 2 / BoundingDiagonal(points);
  s.translation = -s.scale * points.colwise().mean().transpose();
  return s;
}

class Registration {
 public:
  Registration(const Mesh& source, const Mesh& target, const std::vector<LandmarkGoal>& landmarks,
               const Eigen::VectorXd& stiffness, const NricpOptions& options, Progress* progress)
      : source_(source),
        target_(target),
        options_(options),
        progress_(progress),
        stiffness_(stiffness) {
    const Eigen::Index count = std::ssize(landmarks);
    PointsX3 from(count, 3), to(count, 3);
    for (Eigen::Index l = 0; l < count; ++l) {
      from.row(l) = PositionOf(landmarks[l].source, source.points);
      to.row(l) = landmarks[l].target;
      marks_.push_back(landmarks[l].source);
    }
    {
      Stopwatch watch(result_.seconds_align);
      result_.alignment = AlignGlobally(source, target, from, to);
    }
    normal_from_target_ = Normalisation(target.points);
    terms_.landmarks = Transformed(normal_from_target_, to);
    terms_.gamma = options.gamma;
  }

  NricpResult Run() {
    const PointsX3 rest = Transformed(
        normal_from_target_, Transformed(result_.alignment.target_from_source, source_.points));
    const TargetSurface target(Transformed(normal_from_target_, target_.points), target_.faces);
    NricpSystem system = Analysed(rest);
    Eigen::MatrixXd x = system.Identity();
    for (int step = 0; step < options_.alpha_steps; ++step) {
      const double along =
          options_.alpha_steps > 1 ? static_cast<double>(step) / (options_.alpha_steps - 1) : 0.0;
      terms_.alpha = options_.alpha_max * std::pow(options_.alpha_min / options_.alpha_max, along);
      terms_.beta = terms_.alpha > options_.beta_until ? options_.beta_ratio * terms_.alpha : 0.0;
      ReportProgress(progress_, static_cast<double>(step) / options_.alpha_steps,
                     "bending the template, stiffness " + std::to_string(terms_.alpha));
      Round(system, target, x);
    }
    result_.points = Transformed(normal_from_target_.Inverse(), system.Deformed(x));
    const Similarity3& place = result_.alignment.target_from_source;
    for (Eigen::Index v = 0; v < rest.rows(); ++v)
      result_.transforms.push_back(x.block<3, 3>(4 * v, 0).transpose() *
                                   (place.scale * place.rotation));
    result_.analyses = system.analyses();
    result_.factorisations = system.factorisations();
    result_.pcg_steps = system.pcg_steps();
    result_.kept = terms_.weights.mean();
    if (!result_.points.allFinite())
      throw SolverError(
          "register: the result is not finite; raise alpha_min or check the source's triangles");
    return result_;
  }

 private:
  NricpSystem Analysed(const PointsX3& rest) {
    Stopwatch watch(result_.seconds_solve);
    return NricpSystem(rest, source_.faces, marks_, stiffness_);
  }

  /// Searches and solves at one stiffness until X hardly changes. (The printed test in Algorithm 1
  /// is reversed.)
  void Round(NricpSystem& system, const TargetSurface& target, Eigen::MatrixXd& x) {
    for (int inner = 0; inner < options_.max_inner; ++inner) {
      if (progress_ && progress_->cancelled()) throw Cancelled();
      {
        Stopwatch watch(result_.seconds_search);
        Correspondences found = target.Find(system.Deformed(x), source_.faces);
        terms_.closest = std::move(found.closest);
        terms_.weights = std::move(found.weights);
      }
      Stopwatch watch(result_.seconds_solve);
      system.Refill(terms_, x);
      Eigen::MatrixXd next = options_.exact_solves ? system.SolveDirect()
                                                   : system.SolveNear(x, kPcgTolerance, kPcgSteps);
      ++result_.iterations;
      result_.loose_components = std::max(result_.loose_components, system.loose_components());
      const double moved =
          (next - x).norm() / std::sqrt(static_cast<double>(source_.vertex_count()));
      x = std::move(next);
      if (moved < options_.epsilon) return;
    }
    ++result_.unconverged_rounds;
  }

  const Mesh& source_;
  const Mesh& target_;
  const NricpOptions& options_;
  Progress* progress_;
  Eigen::VectorXd stiffness_;
  std::vector<SurfacePoint> marks_;
  Similarity3 normal_from_target_;
  NricpTerms terms_;
  NricpResult result_;
};

}  // namespace

NricpResult RegisterNricp(const Mesh& source, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks,
                          const Eigen::VectorXd& stiffness, const NricpOptions& options,
                          Progress* progress) {
  CheckInputs(source, target, landmarks, stiffness);
  return Registration(source, target, landmarks, stiffness, options, progress).Run();
}

}  // namespace keypose::registration
