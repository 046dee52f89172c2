#include "reconstruct/outline_evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/kd_tree.h"
#include "core/parallel.h"
#include "reconstruct/cloud_rows.h"
#include "reconstruct/facing_cells.h"

namespace keypose::reconstruct {
namespace {

constexpr int kNeighbors = 24;  // rim sites that are asked about a site
constexpr int kLeastWitnesses = 3;
constexpr double kHighest = 20;  // footprints; what lies farther above or below is of another part
constexpr double kLeastFacing = 0.6;
constexpr int kLeastMeasured = 30;  // sites in a class, for its error to mean something
// Errors of one rim site: of its place, of its tangent, and of masks as a whole, which neighbours share. Footprints, radians.
constexpr double kPlaceError = 0.5, kTangentError = 0.1, kSharedError = 0.3;
constexpr double kBend = 40;          // curvature to reckon with, one over extents
constexpr double kModelError = 1.2;   // what a quadric misses: this times the distance to the rim points squared, over the extent
constexpr double kAgreement = 0.6;    // footprints
constexpr double kUsefulError = 2.5;  // a guess that may be farther off than this says nothing

enum class Verdict { kKept, kContradicted, kDropped };

struct Site {
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  double confidence = 0;
  int points = 0;
  bool witnessed = false;
  double miss = 0, miss_error = 0;                           // the surface by the rim points, above the site along its normal, footprints
  Eigen::Vector3d tangent_normal = Eigen::Vector3d::Zero();  // of that surface
  Verdict verdict = Verdict::kKept;
};

struct Sites {
  std::vector<int> site_of;
  std::vector<Site> sites;
};

// Points of one small cell that face into the same octant.
Sites GroupPoints(const PointCloud& cloud, double cell) {
  const std::vector<KeyedPoint> keyed = SortByFacingCell(cloud, cell);
  Sites out;
  out.site_of.resize(keyed.size());
  for (std::size_t k = 0; k < keyed.size(); ++k) {
    if (k == 0 || keyed[k].key != keyed[k - 1].key) out.sites.emplace_back();
    Site& site = out.sites.back();
    const int i = keyed[k].point;
    out.site_of[i] = static_cast<int>(out.sites.size()) - 1;
    site.point += cloud.points.row(i), site.normal += cloud.normals.row(i);
    site.confidence += cloud.confidence[i];
    ++site.points;
  }
  for (Site& site : out.sites) {
    site.point /= site.points, site.confidence /= site.points;
    site.normal.normalize();
  }
  return out;
}

PointsX3 Places(const std::vector<Site>& sites) {
  PointsX3 points(static_cast<Eigen::Index>(sites.size()), 3);
  for (std::size_t i = 0; i < sites.size(); ++i) points.row(static_cast<Eigen::Index>(i)) = sites[i].point;
  return points;
}

// A quadric over the tangent plane, through places and tangents of rim sites; only its height above the site is wanted, and its error.
class Quadric {
 public:
  using Row = Eigen::Matrix<double, 6, 1>;
  explicit Quadric(double bend) {
    a_.setZero(), b_.setZero();
    a_.diagonal().tail<3>().setConstant(1 / (bend * bend));
    a_.diagonal().head<3>().setConstant(1e-9);
  }
  // z = c0 + c1 u + c2 v + c3 u^2/2 + c4 uv + c5 v^2/2
  void Add(double u, double v, const Eigen::Vector3d& normal, double z, double weight) {
    Row place;
    place << 1, u, v, 0.5 * u * u, u * v, 0.5 * v * v;
    AddRow(place, z, weight / (kPlaceError * kPlaceError));
    Row along_u, along_v;
    along_u << 0, 1, 0, u, v, 0;
    along_v << 0, 0, 1, 0, u, v;
    const double w = weight / (kTangentError * kTangentError);
    AddRow(along_u, -normal.x() / normal.z(), w), AddRow(along_v, -normal.y() / normal.z(), w);
  }
  // Height, and tilts in u and v; and the height's variance.
  Eigen::Vector3d Solve(double* variance) const {
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> ldlt(a_);
    *variance = ldlt.solve(Row::Unit(0))[0];
    return ldlt.solve(b_).head<3>();
  }

 private:
  void AddRow(const Row& row, double value, double weight) {
    a_ += weight * row * row.transpose();
    b_ += weight * value * row;
  }
  Eigen::Matrix<double, 6, 6> a_;
  Row b_;
};

// Lengths in footprints.
struct Scale {
  double footprint, extent, reach;
};

void Witness(const std::vector<Site>& rims, const KdTree& tree, const Scale& scale, Site* site) {
  const double footprint = scale.footprint;
  const double farthest = std::hypot(scale.reach, kHighest) * footprint;
  if (tree.Nearest(site->point).squared_distance > farthest * farthest) return;
  const std::vector<KdTree::Neighbor> nearest = tree.Nearest(site->point, kNeighbors);
  Eigen::Matrix3d axes;  // the site's tangents and normal in rows
  axes.row(2) = site->normal;
  axes.row(0) = site->normal.unitOrthogonal();
  axes.row(1) = site->normal.cross(axes.row(0).transpose());
  Quadric quadric(kBend / scale.extent);
  int count = 0;
  double weights = 0, distances = 0;
  for (const KdTree::Neighbor& near : nearest) {
    const Site& rim = rims[near.index];
    const Eigen::Vector3d n = axes * rim.normal, offset = axes * (rim.point - site->point) / footprint;
    const double aside = offset.head<2>().norm();
    if (n.z() < kLeastFacing || aside > scale.reach || std::abs(offset.z()) > kHighest) continue;
    const double weight = rim.confidence * std::exp(-2 * (aside / scale.reach) * (aside / scale.reach));
    quadric.Add(offset.x(), offset.y(), n, offset.z(), weight);
    weights += weight, distances += weight * aside * aside;
    ++count;
  }
  if (count < kLeastWitnesses) return;
  double variance = 0;
  const Eigen::Vector3d surface = quadric.Solve(&variance);
  site->miss = surface[0];
  site->tangent_normal = (axes.transpose() * Eigen::Vector3d(-surface[1], -surface[2], 1)).normalized();
  const double model = kModelError * distances / weights / scale.extent;
  site->miss_error = std::sqrt(variance + kSharedError * kSharedError + model * model);
  site->witnessed = surface.allFinite() && site->miss_error < kUsefulError;
}

int ClassOf(double confidence) { return std::clamp(static_cast<int>(confidence * kErrorClasses), 0, kErrorClasses - 1); }

// The median miss is two thirds of a standard deviation, and the quadrics' own error is in it. Surer classes do not err more than others.
std::array<double, kErrorClasses> ErrorsByClass(const std::vector<Site>& sites) {
  constexpr double kGood = 0.8;
  std::array<std::vector<double>, kErrorClasses> misses;
  std::array<double, kErrorClasses> own{}, errors{};
  for (const Site& site : sites)
    if (site.witnessed && site.miss_error < kGood) {
      const int k = ClassOf(site.confidence);
      misses[k].push_back(std::abs(site.miss));
      own[k] += site.miss_error * site.miss_error;
    }
  double surer = 0.2;
  for (int k = kErrorClasses - 1; k >= 0; --k) {
    std::vector<double>& values = misses[k];
    if (static_cast<int>(values.size()) >= kLeastMeasured) {
      std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
      const double spread = 1.4826 * values[values.size() / 2];
      surer = std::max(surer, std::sqrt(std::max(0.0, spread * spread - own[k] / static_cast<double>(values.size()))));
    }
    errors[k] = surer;
  }
  return errors;
}

// What rim points do not reach goes with its neighbours, when most of them go: a highlight is wrong as a whole.
void Spread(const Scale& scale, std::vector<Site>* sites) {
  constexpr double kMost = 0.6;
  const KdTree tree(Places(*sites));
  std::vector<char> goes(sites->size(), 0);
  ParallelFor(
      static_cast<std::int64_t>(sites->size()),
      [&](std::int64_t i) {
        const Site& site = (*sites)[i];
        if (site.witnessed) return;
        int asked = 0, contradicted = 0;
        const double reach = scale.reach * scale.footprint;
        for (const KdTree::Neighbor& near : tree.Nearest(site.point, kNeighbors)) {
          const Site& other = (*sites)[near.index];
          if (!other.witnessed || near.squared_distance > reach * reach || other.normal.dot(site.normal) < kLeastFacing) continue;
          ++asked, contradicted += other.verdict == Verdict::kContradicted;
        }
        goes[i] = asked >= kLeastWitnesses && contradicted >= kMost * asked;
      },
      64);
  for (std::size_t i = 0; i < goes.size(); ++i)
    if (goes[i]) (*sites)[i].verdict = Verdict::kContradicted;
}

// Along the normal to the hull, or to the rim points' surface where that lies below it. False when the hull is farther than any miss that
// is believed.
bool ToHull(const Silhouettes& silhouettes, double footprint, Site* site) {
  constexpr int kHalvings = 8;
  double inner = 0, outer = kHighest;
  auto within = [&](double t) { return silhouettes.Within(site->point + t * footprint * site->normal, 0); };
  if (site->witnessed && site->miss < kHighest) {
    outer = site->miss;
    if (within(outer)) return true;
  } else if (within(outer)) {
    return false;
  }
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (inner + outer);
    (within(middle) ? inner : outer) = middle;
  }
  site->miss = inner;
  return true;
}

// Where a contradicted site goes. What lies above the rim points' surface is noise: there is no telling what is below it.
void Place(const Silhouettes& silhouettes, double footprint, Site* site) {
  if (!site->witnessed) site->tangent_normal = site->normal;
  if ((site->witnessed && site->miss < 0) || !ToHull(silhouettes, footprint, site)) site->verdict = Verdict::kDropped;
}

// Where a point of a site goes. @return false when it is dropped
bool Move(const Site& site, double error, double footprint, Eigen::Index i, PointCloud* cloud) {
  if (site.verdict == Verdict::kDropped) return false;
  if (site.verdict == Verdict::kKept) {
    if (!site.witnessed) return true;
    // Masks and stereo may differ by a constant fraction of a pixel, which is no reason to move anything.
    const double share = error * error / (error * error + site.miss_error * site.miss_error);
    const double miss = std::copysign(std::max(0.0, std::abs(site.miss) - kAgreement), site.miss);
    cloud->points.row(i) += (share * miss * footprint) * site.normal.transpose();
    return true;
  }
  // The site's points become a patch of the surface.
  const Eigen::Vector3d offset = cloud->points.row(i).transpose() - site.point, n = site.tangent_normal;
  cloud->points.row(i) = site.point + site.miss * footprint * site.normal + offset - offset.dot(n) * n;
  cloud->normals.row(i) = n;
  cloud->confidence[i] = std::min(cloud->confidence[i], kOutlineConfidence);
  return true;
}

}  // namespace

OutlineEvidence HearOutlines(PointCloud cloud, const PointCloud& rims, const Silhouettes& silhouettes, double footprint, double extent,
                             const OutlineEvidenceOptions& options) {
  OutlineEvidence out;
  out.cloud = std::move(cloud);
  if (out.cloud.points.rows() == 0 || rims.points.rows() == 0) return out;
  const Scale scale{footprint, extent / footprint, options.reach * extent / footprint};
  const double cell = std::max(options.site * extent, 3 * footprint);
  const std::vector<Site> rim_sites = GroupPoints(rims, cell).sites;
  const KdTree tree(Places(rim_sites));
  Sites grouped = GroupPoints(out.cloud, cell);
  std::vector<Site>& sites = grouped.sites;
  const std::int64_t count = static_cast<std::int64_t>(sites.size());
  ParallelFor(
      count, [&](std::int64_t i) { Witness(rim_sites, tree, scale, &sites[i]); }, 64);
  out.errors = ErrorsByClass(sites);
  for (Site& site : sites) {
    const double error = std::min(kUsefulError, std::hypot(site.miss_error, out.errors[ClassOf(site.confidence)]));
    if (site.witnessed && std::abs(site.miss) > std::max(options.least_limit, options.errors * error))
      site.verdict = Verdict::kContradicted;
  }
  Spread(scale, &sites);
  ParallelFor(
      count,
      [&](std::int64_t i) {
        if (sites[i].verdict == Verdict::kContradicted) Place(silhouettes, footprint, &sites[i]);
      },
      64);
  std::vector<char> keep(grouped.site_of.size());
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const Site& site = sites[grouped.site_of[i]];
    keep[i] = Move(site, out.errors[ClassOf(site.confidence)], footprint, static_cast<Eigen::Index>(i), &out.cloud);
    out.contradicted += site.verdict == Verdict::kContradicted;
    out.dropped += site.verdict == Verdict::kDropped;
  }
  KeepRows(keep, &out.cloud);
  return out;
}

}  // namespace keypose::reconstruct
