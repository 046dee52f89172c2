// Linear constraints of PoissonSystem: multipliers, floors, projections.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>

#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "deform/poisson/poisson_impl.h"

namespace keypose {

namespace {

constexpr double kDependent = 1e-9;  // relative pivot below which a row depends on earlier ones
constexpr int kColumns = 48;
constexpr int kMaxFloorPasses = 40;

ConstraintRow Checked(const ConstraintRow& row, Eigen::Index vertex_count) {
  const std::string what = "interpolate: constraint '" + row.name + "'";
  std::map<int, double> merged;
  for (const auto& [vertex, weight] : row.terms) {
    RequireVertex(vertex, vertex_count, what, "the keys have", "");
    if (!std::isfinite(weight)) throw InputError(what + " has a weight that is not finite");
    merged[vertex] += weight;
  }
  RequireNotNegative(row.compliance, what + " has a compliance that");
  ConstraintRow checked{{}, row.compliance, row.name};
  for (const auto& term : merged)
    if (term.second != 0) checked.terms.push_back(term);
  return checked;
}

/// The rows of a symmetric positive semidefinite matrix that do not depend on earlier ones, by
/// Cholesky without pivoting.
std::vector<int> IndependentRows(const Eigen::MatrixXd& gram) {
  std::vector<int> kept;
  Eigen::MatrixXd l(gram.rows(), gram.rows());
  for (Eigen::Index i = 0; i < gram.rows(); ++i) {
    const Eigen::Index k = std::ssize(kept);
    Eigen::VectorXd row(k);
    for (Eigen::Index j = 0; j < k; ++j)
      row[j] = (gram(i, kept[j]) - row.head(j).dot(l.row(j).head(j))) / l(j, j);
    const double pivot = gram(i, i) - row.squaredNorm();
    if (!(pivot > kDependent * gram(i, i))) continue;
    l.row(k).head(k) = row;
    l(k, k) = std::sqrt(pivot);
    kept.push_back(static_cast<int>(i));
  }
  return kept;
}

ConstraintRow VertexRow(int vertex) { return {{{vertex, 1.0}}, 0, ""}; }

void AddColumn(const ConstraintRow& row, double factor, Eigen::Ref<Eigen::VectorXd> column) {
  for (const auto& [vertex, weight] : row.terms) column[vertex] += factor * weight;
}

double ValueOf(const ConstraintRow& row, const Eigen::Ref<const Eigen::VectorXd>& x) {
  double value = 0;
  for (const auto& [vertex, weight] : row.terms) value += weight * x[vertex];
  return value;
}

}  // namespace

Eigen::MatrixXd PoissonSystem::Impl::ValuesOf(const std::vector<ConstraintRow>& some,
                                              const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd values(some.size(), x.cols());
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (std::size_t r = 0; r < some.size(); ++r) values(r, c) = ValueOf(some[r], x.col(c));
  return values;
}

Eigen::MatrixXd PoissonSystem::Impl::Compliance(const BlockCholesky& system,
                                                const std::vector<ConstraintRow>& some) const {
  const Eigen::Index m = std::ssize(some);
  Eigen::MatrixXd result(m, m);
  for (Eigen::Index begin = 0; begin < m; begin += kColumns) {
    const Eigen::Index count = std::min<Eigen::Index>(kColumns, m - begin);
    Eigen::MatrixXd z = Eigen::MatrixXd::Zero(n, count);
    for (Eigen::Index c = 0; c < count; ++c) AddColumn(some[begin + c], 1, z.col(c));
    system.SolveInPlace(z);
    result.middleCols(begin, count) = ValuesOf(some, z);
  }
  return 0.5 * (result + result.transpose());
}

void PoissonSystem::Impl::AcceptRows(const std::vector<ConstraintRow>& given) {
  std::vector<ConstraintRow> checked;
  for (const ConstraintRow& row : given) checked.push_back(Checked(row, n));
  Eigen::MatrixXd gram = Compliance(solver, checked);
  for (std::size_t r = 0; r < checked.size(); ++r) gram(r, r) += checked[r].compliance;
  const std::vector<int> kept = IndependentRows(gram);
  for (std::size_t r = 0, k = 0; r < checked.size(); ++r)
    if (k < kept.size() && kept[k] == static_cast<int>(r)) {
      rows.push_back(checked[r]);
      sources.push_back(static_cast<int>(r));
      ++k;
    } else {
      dropped.push_back(checked[r].name);
    }
  AddCentroidRows();
  FactorRows();
}

void PoissonSystem::Impl::AddCentroidRows() {
  std::vector<char> touched(part_count, 0);
  for (const ConstraintRow& row : rows)
    for (const auto& term : row.terms) touched[parts[term.first]] = 1;
  std::vector<int> place(part_count, -1);
  for (int p = 0; p < part_count; ++p)
    if (touched[p]) {
      place[p] = SizeOf(touched_parts);
      touched_parts.push_back(p);
    }
  part_sums = Eigen::MatrixXd::Zero(std::ssize(rows), std::ssize(touched_parts));
  double scale = 0;
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (const auto& [vertex, weight] : rows[r].terms) {
      part_sums(r, place[parts[vertex]]) += weight;
      scale = std::max(scale, std::abs(weight));
    }
  // Finds the parts that the rows place, by elimination of columns. A part without a pivot can
  // still be shifted and gets a centroid row.
  std::vector<char> needs(part_count, 0);
  Eigen::MatrixXd left = part_sums;
  for (std::size_t c = 0; c < touched_parts.size(); ++c) {
    Eigen::Index pivot = 0;
    const double largest = left.rows() > 0 ? left.col(c).cwiseAbs().maxCoeff(&pivot) : 0;
    if (!(largest > kDependent * scale)) {
      needs[touched_parts[c]] = 1;
      continue;
    }
    const Eigen::RowVectorXd pivot_row = left.row(pivot) / left(pivot, c);
    left -= left.col(c).eval() * pivot_row;
    left.row(pivot).setZero();
  }
  std::vector<std::vector<int>> members(part_count);
  for (int i = 0; i < static_cast<int>(n); ++i)
    if (!touched[parts[i]] || needs[parts[i]]) members[parts[i]].push_back(i);
  const auto add_centroid = [&](int part) {
    ConstraintRow row{{}, 0, "centroid of part " + std::to_string(part)};
    for (int i : members[part]) row.terms.emplace_back(i, 1.0 / part_size[part]);
    rows.push_back(std::move(row));
    sources.push_back(-1 - part);
  };
  for (int p : touched_parts)
    if (needs[p]) add_centroid(p);
  coupled = SizeOf(rows);
  part_sums.conservativeResize(coupled, Eigen::NoChange);
  for (int r = 0; r < coupled; ++r) {
    if (sources[r] >= 0) continue;
    part_sums.row(r).setZero();
    part_sums(r, place[-1 - sources[r]]) = 1;
  }
  for (int p = 0; p < part_count; ++p)
    if (!touched[p]) add_centroid(p);
}

void PoissonSystem::Impl::FactorRows() {
  if (coupled == 0) return;
  const std::vector<ConstraintRow> coupled_rows(rows.begin(), rows.begin() + coupled);
  compliance = Compliance(solver, coupled_rows);
  for (int r = 0; r < coupled; ++r) compliance(r, r) += rows[r].compliance;
  const Eigen::Index p = part_sums.cols();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(coupled + p, coupled + p);
  system << compliance, -part_sums, part_sums.transpose(), Eigen::MatrixXd::Zero(p, p);
  multipliers.compute(system);
  std::copy_if(coupled_rows.begin(), coupled_rows.end(), std::back_inserter(exact),
               [](const auto& row) { return row.compliance == 0; });
  if (options.screened && !exact.empty()) exact_screened.compute(Compliance(screened, exact));
}

void PoissonSystem::Impl::SolveWithRows(Eigen::MatrixXd& x,
                                        const std::vector<RowTargets>& targets) const {
  if (coupled == 0) return solver.SolveInPlace(x);
  const Eigen::MatrixXd rhs = x;
  solver.SolveInPlace(x);
  const std::vector<ConstraintRow> coupled_rows(rows.begin(), rows.begin() + coupled);
  Eigen::MatrixXd gap = Eigen::MatrixXd::Zero(coupled + part_sums.cols(), x.cols());
  gap.topRows(coupled) = ValuesOf(coupled_rows, x);
  for (std::size_t t = 0; t < targets.size(); ++t)
    gap.block(0, 3 * t, coupled, 3) -= targets[t].topRows(coupled);
  const Eigen::MatrixXd found = multipliers.solve(gap);
  // Solves again with the multipliers' forces on the right-hand side, so the columns H^-1 C^T, one
  // for each row, need not be stored.
  x = rhs;
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (int r = 0; r < coupled; ++r) AddColumn(rows[r], -found(r, c), x.col(c));
  solver.SolveInPlace(x);
  std::vector<int> place(part_count, -1);
  for (std::size_t p = 0; p < touched_parts.size(); ++p)
    place[touched_parts[p]] = static_cast<int>(p);
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (Eigen::Index i = 0; i < n; ++i)
      if (place[parts[i]] >= 0) x(i, c) += found(coupled + place[parts[i]], c);
}

void PoissonSystem::Impl::CentreFreeParts(PointsX3& points, const RowTargets& targets) const {
  if (coupled == std::ssize(rows)) return;
  RowTargets shift = RowTargets::Zero(part_count, 3);
  for (Eigen::Index i = 0; i < n; ++i) shift.row(parts[i]) -= points.row(i);
  std::vector<char> is_free(part_count, 0);
  for (std::size_t r = coupled; r < rows.size(); ++r) {
    const int p = -1 - sources[r];
    is_free[p] = 1;
    shift.row(p) = targets.row(r) + shift.row(p) / part_size[p];
  }
  for (Eigen::Index i = 0; i < n; ++i)
    if (is_free[parts[i]]) points.row(i) += shift.row(parts[i]);
}

/// Finds the vertices that rest on the floor, and the change of z that holds them there.
class PoissonSystem::FloorSearch {
 public:
  FloorSearch(const Impl& system, const PointsX3& points, const std::vector<int>& candidates,
              double height)
      : s_(system),
        points_(points),
        candidates_(candidates),
        height_(height),
        coupled_(system.rows.begin(), system.rows.begin() + system.coupled),
        cross_(system.coupled, 0),
        own_(0, 0),
        place_(system.n, -1),
        part_place_(system.part_count, -1),
        z_(points.col(2)) {
    for (std::size_t k = 0; k < s_.touched_parts.size(); ++k)
      part_place_[s_.touched_parts[k]] = static_cast<int>(k);
    for (int i : candidates)
      if (points(i, 2) < height) active_.push_back(i);
  }

  void Run() {
    for (int pass = 0; pass < kMaxFloorPasses && !active_.empty(); ++pass) {
      LearnCompliance();
      if (!Update(Hold(), pass > kMaxFloorPasses / 2)) return;
    }
  }
  const Eigen::VectorXd& z() const { return z_; }
  const std::vector<int>& active() const { return active_; }

 private:
  /// Columns of H^-1 for newly active vertices. Only the needed entries are kept: at active
  /// vertices and in the rows.
  void LearnCompliance() {
    std::vector<int> fresh;
    for (int i : active_)
      if (place_[i] < 0) {
        place_[i] = SizeOf(known_);
        known_.push_back(i);
        fresh.push_back(i);
      }
    const Eigen::Index k0 = own_.rows(), k1 = std::ssize(known_);
    own_.conservativeResize(k1, k1);
    cross_.conservativeResize(s_.coupled, k1);
    for (std::size_t b = 0; b < fresh.size(); b += kColumns) {
      const Eigen::Index count =
          std::min<Eigen::Index>(kColumns, static_cast<Eigen::Index>(fresh.size() - b));
      Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(s_.n, count);
      for (Eigen::Index c = 0; c < count; ++c) columns(fresh[b + c], c) = 1;
      s_.solver.SolveInPlace(columns);
      for (Eigen::Index c = 0; c < count; ++c) {
        const Eigen::Index at = k0 + static_cast<Eigen::Index>(b) + c;
        for (Eigen::Index r = 0; r < k1; ++r) own_(r, at) = own_(at, r) = columns(known_[r], c);
        for (int r = 0; r < s_.coupled; ++r) cross_(r, at) = ValueOf(coupled_[r], columns.col(c));
      }
    }
  }

  /// The multipliers of rows and active vertices, and the shifts of parts, that hold the active
  /// vertices at the floor.
  Eigen::VectorXd Hold() const {
    const Eigen::Index m = s_.coupled, a = std::ssize(active_), p = s_.part_sums.cols();
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(m + a + p, m + a + p);
    Eigen::VectorXd goal = Eigen::VectorXd::Zero(m + a + p);
    system.topLeftCorner(m, m) = s_.compliance;
    system.block(0, m + a, m, p) = -s_.part_sums;
    system.block(m + a, 0, p, m) = s_.part_sums.transpose();
    for (Eigen::Index r = 0; r < a; ++r) {
      const int at = place_[active_[r]], q = part_place_[s_.parts[active_[r]]];
      system.block(0, m + r, m, 1) = cross_.col(at);
      system.block(m + r, 0, 1, m) = cross_.col(at).transpose();
      for (Eigen::Index c = 0; c < a; ++c) system(m + r, m + c) = own_(at, place_[active_[c]]);
      system(m + r, m + a + q) = -1;
      system(m + a + q, m + r) = 1;
      goal[m + r] = points_(active_[r], 2) - height_;
    }
    return system.partialPivLu().solve(goal);
  }

  /// Moves z, releases held vertices that are pulled down, and adds vertices below the floor. Late
  /// passes only add, so that the search ends.
  /// @return whether the active set changed
  bool Update(const Eigen::VectorXd& found, bool only_add) {
    const Eigen::Index m = s_.coupled, a = std::ssize(active_);
    Eigen::MatrixXd move = Eigen::MatrixXd::Zero(s_.n, 1);
    for (Eigen::Index r = 0; r < m; ++r) AddColumn(s_.rows[r], -found[r], move.col(0));
    for (Eigen::Index r = 0; r < a; ++r) move(active_[r], 0) -= found[m + r];
    s_.solver.SolveInPlace(move);
    for (Eigen::Index i = 0; i < s_.n; ++i) {
      const int q = part_place_[s_.parts[i]];
      z_[i] = points_(i, 2) + (q >= 0 ? move(i, 0) + found[m + a + q] : 0.0);
    }
    if (!z_.allFinite())
      throw InputError(
          "interpolate: the floor and a constraint contradict each other; a pinned vertex lies "
          "below the floor");
    std::vector<char> seen(s_.n, 0);
    std::vector<int> next;
    for (Eigen::Index r = 0; r < a; ++r)
      if (found[m + r] <= 0 || only_add) next.push_back(active_[r]);
    bool changed = std::ssize(next) != a;
    for (int i : active_) {
      z_[i] = height_;
      seen[i] = 1;
    }
    for (int i : candidates_)
      if (!seen[i] && z_[i] < height_ - 1e-12 * (1 + std::abs(height_))) {
        next.push_back(i);
        changed = true;
      }
    if (changed) {
      std::sort(next.begin(), next.end());
      active_ = std::move(next);
    }
    return changed;
  }

  const Impl& s_;
  const PointsX3& points_;
  const std::vector<int>& candidates_;
  double height_;
  std::vector<ConstraintRow> coupled_;
  std::vector<int> known_, active_;  // vertices whose compliance is known; those held now
  Eigen::MatrixXd cross_, own_;
  std::vector<int> place_, part_place_;
  Eigen::VectorXd z_;
};

std::vector<int> PoissonSystem::LiftToFloor(PointsX3& points, const Floor& floor) const {
  const Impl& s = *impl_;
  std::vector<int> candidates = floor.vertices;
  if (candidates.empty()) {
    candidates.resize(s.n);
    std::iota(candidates.begin(), candidates.end(), 0);
  }
  for (const int i : candidates)
    RequireVertex(i, s.n, "interpolate: the floor", "the keys have", "");
  std::vector<char> is_free(s.part_count, 0);
  for (std::size_t r = s.coupled; r < s.rows.size(); ++r) is_free[-1 - s.sources[r]] = 1;
  Eigen::VectorXd lift = Eigen::VectorXd::Zero(s.part_count);
  std::vector<int> bent;
  for (int i : candidates)
    if (is_free[s.parts[i]])
      lift[s.parts[i]] = std::max(lift[s.parts[i]], floor.height - points(i, 2));
    else
      bent.push_back(i);
  for (Eigen::Index i = 0; i < s.n; ++i) points(i, 2) += lift[s.parts[i]];
  for (int i : candidates)
    if (is_free[s.parts[i]]) points(i, 2) = std::max(points(i, 2), floor.height);
  std::vector<char> checked(s.n, 0);
  for (int i : bent) checked[i] = 1;
  for (const ConstraintRow& row : s.exact) {
    const int i = row.terms[0].first;
    if (row.terms.size() == 1 && checked[i] &&
        points(i, 2) < floor.height - 1e-9 * (1 + std::abs(floor.height)))
      throw InputError("interpolate: constraint '" + row.name + "' holds vertex " +
                       std::to_string(i) + " below the floor; move the pin up or the floor down");
  }
  if (s.coupled == 0) return {};
  FloorSearch search(s, points, bent, floor.height);
  search.Run();
  points.col(2) = search.z();
  for (int i : bent) points(i, 2) = std::max(points(i, 2), floor.height);
  return search.active();
}

PointsX3 PoissonSystem::WithoutRows(PointsX3 displacement, const std::vector<int>& held) const {
  const Impl& s = *impl_;
  if (!s.exact.empty() || !held.empty()) {
    Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(s.n, 3);
    const Eigen::MatrixXd values = s.ValuesOf(s.exact, displacement);
    Eigen::MatrixXd found = s.exact.empty() ? values : s.exact_screened.solve(values).eval();
    for (int c = 0; c < 3; ++c)
      for (std::size_t r = 0; r < s.exact.size(); ++r)
        AddColumn(s.exact[r], found(r, c), pull.col(c));
    if (!held.empty()) {
      std::vector<ConstraintRow> all = s.exact;
      for (int i : held) all.push_back(VertexRow(i));
      const Eigen::VectorXd z_found =
          s.Compliance(s.screened, all).partialPivLu().solve(s.ValuesOf(all, displacement.col(2)));
      pull.col(2).setZero();
      for (std::size_t r = 0; r < all.size(); ++r) AddColumn(all[r], z_found[r], pull.col(2));
    }
    s.screened.SolveInPlace(pull);
    displacement -= pull;
  }
  PointsX3 mean = PointsX3::Zero(s.part_count, 3);
  for (Eigen::Index i = 0; i < s.n; ++i) mean.row(s.parts[i]) += displacement.row(i);
  for (int p = 0; p < s.part_count; ++p) mean.row(p) /= s.part_size[p];
  std::vector<char> is_free(s.part_count, 0);
  for (std::size_t r = s.coupled; r < s.rows.size(); ++r) is_free[-1 - s.sources[r]] = 1;
  for (Eigen::Index i = 0; i < s.n; ++i)
    if (is_free[s.parts[i]]) displacement.row(i) -= mean.row(s.parts[i]);
  return displacement;
}

}  // namespace keypose
