#include "register/nricp/nricp_system.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <iterator>
#include <string>

#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "deform/solvers/cholmod_factor.h"
#include "deform/solvers/sparse_pattern.h"

namespace keypose::registration {

namespace {

using RowVector4 = Eigen::Matrix<double, 1, 4>;

std::vector<std::pair<int, int>> MixedPairs(const std::vector<SurfacePoint>& landmarks) {
  std::vector<std::pair<int, int>> pairs;
  for (const SurfacePoint& l : landmarks)
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 3; ++b)
        if (l.weights[a] != 0 && l.weights[b] != 0 && l.vertices[a] != l.vertices[b])
          pairs.emplace_back(l.vertices[a], l.vertices[b]);
  return pairs;
}

}  // namespace

struct NricpSystem::Impl {
  Impl(const PointsX3& p, const FacesX3& faces, const std::vector<SurfacePoint>& l)
      : landmarks(l),
        pattern(MakeSparsePattern(static_cast<int>(p.rows()), faces, MixedPairs(l))),
        factor(pattern) {
    homogeneous.resize(p.rows(), 4);
    homogeneous << p, Eigen::VectorXd::Ones(p.rows());
    component = Components(pattern.vertex_count, pattern.edges, component_count);
    values.assign(pattern.nonzeros(), 0.0);
    rhs.setZero(4 * p.rows(), 3);
  }

  Eigen::MatrixXd Multiply(const Eigen::MatrixXd& x) const;
  void AddStiffness(const NricpTerms& terms);
  void AddData(const NricpTerms& terms);
  void AddLandmarks(const NricpTerms& terms);
  void HoldLooseParts(const Eigen::MatrixXd& current);

  std::vector<SurfacePoint> landmarks;
  SparsePattern pattern;
  CholmodFactor factor;
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> homogeneous;
  std::vector<int> component;
  int component_count = 0, loose = 0;
  Eigen::VectorXd edge_weight;  // m_e^2
  NricpTerms terms;
  std::vector<double> values;
  std::vector<Eigen::Matrix4d> gram;  // per component, of all rows that hold it in place
  Eigen::MatrixXd rhs;
  long pcg_steps = 0;
};

NricpSystem::NricpSystem(const PointsX3& points, const FacesX3& faces,
                         const std::vector<SurfacePoint>& landmarks,
                         const Eigen::VectorXd& stiffness) {
  RequireStiffness(stiffness, points.rows(), "register");
  impl_ = std::make_unique<Impl>(points, faces, landmarks);
  impl_->edge_weight.setOnes(std::ssize(impl_->pattern.edges));
  if (stiffness.size() == 0) return;
  for (std::size_t e = 0; e < impl_->pattern.edges.size(); ++e) {
    const auto [i, j] = impl_->pattern.edges[e];
    impl_->edge_weight[e] = stiffness[i] * stiffness[j];
  }
}

NricpSystem::~NricpSystem() = default;
NricpSystem::NricpSystem(NricpSystem&&) noexcept = default;

void NricpSystem::Impl::AddStiffness(const NricpTerms& t) {
  const double a2 = t.alpha * t.alpha;
  const double g[4] = {a2, a2, a2, a2 * t.gamma * t.gamma};
  for (std::size_t e = 0; e < pattern.edges.size(); ++e) {
    const auto [i, j] = pattern.edges[e];
    for (int k = 0; k < 4; ++k) {
      const double value = edge_weight[e] * g[k];
      values[pattern.edge_slot[e][k] + (pattern.edge_full[e] ? k : 0)] -= value;
      values[pattern.vertex_slot[i][k]] += value;
      values[pattern.vertex_slot[j][k]] += value;
    }
  }
}

void NricpSystem::Impl::AddData(const NricpTerms& t) {
  for (int i = 0; i < pattern.vertex_count; ++i) {
    const double w2 = t.weights[i] * t.weights[i];
    if (w2 == 0) continue;
    const RowVector4 v = homogeneous.row(i);
    for (int k = 0; k < 4; ++k)
      for (int r = k; r < 4; ++r) values[pattern.vertex_slot[i][k] + (r - k)] += w2 * v[k] * v[r];
    rhs.middleRows<4>(4 * i) += w2 * v.transpose() * t.closest.row(i);
    gram[component[i]] += w2 * v.transpose() * v;
  }
}

void NricpSystem::Impl::AddLandmarks(const NricpTerms& t) {
  const double b2 = t.beta * t.beta;
  if (b2 == 0) return;
  for (std::size_t l = 0; l < landmarks.size(); ++l) {
    const SurfacePoint& at = landmarks[l];
    for (int a = 0; a < 3; ++a) {
      if (at.weights[a] == 0) continue;
      const int i = at.vertices[a];
      const RowVector4 vi = at.weights[a] * homogeneous.row(i);
      rhs.middleRows<4>(4 * i) += b2 * vi.transpose() * t.landmarks.row(l);
      for (int b = 0; b < 3; ++b) {
        const int j = at.vertices[b];
        if (at.weights[b] == 0 || j > i || (j == i && b != a)) continue;
        const RowVector4 vj = at.weights[b] * homogeneous.row(j);
        for (int r = 0; r < 4; ++r)
          for (int c = 0; c < (i == j ? r + 1 : 4); ++c)
            values[pattern.Slot(i, r, j, c)] += b2 * vi[r] * vj[c];
      }
    }
    RowVector4 v = RowVector4::Zero();
    for (int a = 0; a < 3; ++a) v += at.weights[a] * homogeneous.row(at.vertices[a]);
    gram[component[at.vertices[0]]] += b2 * v.transpose() * v;
  }
}

/// Adds the weak pull to parts that no term holds in place. Without it, a part whose rows do not
/// determine all twelve numbers of an affine map (no, too few or coplanar points) makes the system
/// singular.
void NricpSystem::Impl::HoldLooseParts(const Eigen::MatrixXd& current) {
  std::vector<char> is_loose(component_count, 0);
  loose = 0;
  for (int c = 0; c < component_count; ++c) {
    const Eigen::Vector4d ev =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(gram[c], Eigen::EigenvaluesOnly)
            .eigenvalues();
    is_loose[c] = !(ev[0] > 1e-11 * ev[3]);
    loose += is_loose[c];
  }
  if (loose == 0) return;
  Eigen::VectorXd trace = Eigen::VectorXd::Zero(component_count),
                  count = Eigen::VectorXd::Zero(component_count);
  for (int i = 0; i < pattern.vertex_count; ++i) {
    for (int k = 0; k < 4; ++k) trace[component[i]] += values[pattern.vertex_slot[i][k]];
    count[component[i]] += 4;
  }
  for (int i = 0; i < pattern.vertex_count; ++i) {
    const int c = component[i];
    if (!is_loose[c]) continue;
    const double pull = 1e-9 * std::max(trace[c] / count[c], 1e-6);
    for (int k = 0; k < 4; ++k) values[pattern.vertex_slot[i][k]] += pull;
    rhs.middleRows<4>(4 * i) += pull * current.middleRows<4>(4 * i);
  }
}

void NricpSystem::Refill(const NricpTerms& terms, const Eigen::MatrixXd& current) {
  Impl& s = *impl_;
  const Eigen::Index n = s.pattern.vertex_count;
  if (terms.weights.size() != n || terms.closest.rows() != n ||
      terms.landmarks.rows() != std::ssize(s.landmarks) || current.rows() != 4 * n ||
      current.cols() != 3)
    throw InputError("register: terms of the system have wrong sizes");
  s.terms = terms;
  std::fill(s.values.begin(), s.values.end(), 0.0);
  s.rhs.setZero();
  s.gram.assign(s.component_count, Eigen::Matrix4d::Zero());
  s.AddStiffness(terms);
  s.AddData(terms);
  s.AddLandmarks(terms);
  s.HoldLooseParts(current);
}

Eigen::MatrixXd NricpSystem::SolveDirect() {
  impl_->factor.Factor(impl_->values);
  Eigen::MatrixXd x;
  impl_->factor.Solve(impl_->rhs, x);
  if (!x.allFinite())
    throw SolverError(
        "register: the solution is not finite; check the source for vertices far from the rest");
  return x;
}

Eigen::MatrixXd NricpSystem::Impl::Multiply(const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(x.rows(), 3);
  const double *x0 = x.col(0).data(), *x1 = x.col(1).data(), *x2 = x.col(2).data();
  double *y0 = y.col(0).data(), *y1 = y.col(1).data(), *y2 = y.col(2).data();
  for (int c = 0; c + 1 < std::ssize(pattern.columns); ++c) {
    int s = pattern.columns[c];
    double sum0 = values[s] * x0[c], sum1 = values[s] * x1[c],
           sum2 = values[s] * x2[c];  // the diagonal comes first
    for (++s; s < pattern.columns[c + 1]; ++s) {
      const int r = pattern.rows[s];
      const double value = values[s];
      sum0 += value * x0[r];
      sum1 += value * x1[r];
      sum2 += value * x2[r];
      y0[r] += value * x0[c];
      y1[r] += value * x1[c];
      y2[r] += value * x2[c];
    }
    y0[c] += sum0;
    y1[c] += sum1;
    y2[c] += sum2;
  }
  return y;
}

Eigen::MatrixXd NricpSystem::SolveNear(const Eigen::MatrixXd& start, double tolerance,
                                       int max_steps) {
  Impl& s = *impl_;
  if (!s.factor.factored()) return SolveDirect();
  Eigen::MatrixXd x = start, r = s.rhs - s.Multiply(x), z, p;
  const Eigen::RowVector3d goal = tolerance * s.rhs.colwise().norm();
  Eigen::RowVector3d rz = Eigen::RowVector3d::Zero();
  // Three conjugate gradient runs in parallel, one per coordinate, so that they share each solve.
  for (int step = 0; step <= max_steps; ++step) {
    if ((r.colwise().norm().array() <= goal.array()).all()) return x;
    if (step == max_steps) break;
    s.factor.Solve(r, z);
    ++s.pcg_steps;
    const Eigen::RowVector3d rz_new = r.cwiseProduct(z).colwise().sum();
    if (step == 0) p = z;
    for (int d = 0; step > 0 && d < 3; ++d)
      p.col(d) = z.col(d) + (rz[d] > 0 ? rz_new[d] / rz[d] : 0.0) * p.col(d);
    rz = rz_new;
    const Eigen::MatrixXd q = s.Multiply(p);
    for (int d = 0; d < 3; ++d) {
      const double pq = p.col(d).dot(q.col(d));
      const double length = pq > 0 ? rz[d] / pq : 0.0;
      x.col(d) += length * p.col(d);
      r.col(d) -= length * q.col(d);
    }
  }
  return SolveDirect();
}

Eigen::MatrixXd NricpSystem::Identity() const {
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(4 * impl_->pattern.vertex_count, 3);
  for (int i = 0; i < impl_->pattern.vertex_count; ++i) x.block<3, 3>(4 * i, 0).setIdentity();
  return x;
}

PointsX3 NricpSystem::Deformed(const Eigen::MatrixXd& x) const {
  PointsX3 moved(impl_->pattern.vertex_count, 3);
  for (int i = 0; i < impl_->pattern.vertex_count; ++i)
    moved.row(i) = impl_->homogeneous.row(i) * x.middleRows<4>(4 * i);
  return moved;
}

double NricpSystem::Energy(const Eigen::MatrixXd& x) const {
  const Impl& s = *impl_;
  const Eigen::Vector4d g(1, 1, 1, s.terms.gamma);
  double energy = 0;
  for (std::size_t e = 0; e < s.pattern.edges.size(); ++e) {
    const auto [i, j] = s.pattern.edges[e];
    energy += s.terms.alpha * s.terms.alpha * s.edge_weight[e] *
              (g.asDiagonal() * (x.middleRows<4>(4 * i) - x.middleRows<4>(4 * j))).squaredNorm();
  }
  const PointsX3 moved = Deformed(x);
  for (int i = 0; i < s.pattern.vertex_count; ++i)
    energy +=
        std::pow(s.terms.weights[i], 2) * (moved.row(i) - s.terms.closest.row(i)).squaredNorm();
  for (std::size_t l = 0; l < s.landmarks.size(); ++l)
    energy +=
        s.terms.beta * s.terms.beta *
        (PositionOf(s.landmarks[l], moved) - s.terms.landmarks.row(l).transpose()).squaredNorm();
  return energy;
}

Eigen::MatrixXd NricpSystem::HalfGradient(const Eigen::MatrixXd& x) const {
  return impl_->Multiply(x) - impl_->rhs;
}

int NricpSystem::analyses() const { return impl_->factor.analyses(); }
int NricpSystem::factorisations() const { return impl_->factor.factorisations(); }
long NricpSystem::pcg_steps() const { return impl_->pcg_steps; }
int NricpSystem::loose_components() const { return impl_->loose; }
long NricpSystem::factor_nonzeros() const { return impl_->factor.nonzeros(); }

}  // namespace keypose::registration
